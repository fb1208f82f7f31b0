//! The prediction table as one page that opens offline: figures, pictures, and the sources of both.

use std::fmt::Write;

use super::pictures::{Curve, Picture, horizon_curve};
use super::prediction::{COLUMNS, Column, MEASURES, PredictionTable, Row, SHOWN_MEASURES};
use super::replay::DRAWN_STEPS;
use super::score::Horizon;
use super::series::Series;
use twin_core::notation::{COORDINATE_NAMES, TICK_S};
use twin_core::residual::REPORTED;
use twin_scenario::markup::{self, escaped};

const STYLE: &str = "
table{min-width:100%;display:block;overflow-x:auto}th,td{text-align:right}th:first-child,td:first-child{text-align:left}
code,.from{font:12px/1.4 ui-monospace,monospace;color:var(--muted);overflow-wrap:anywhere}svg{margin:6px 0}
";

/// Coordinates of the residual that are drawn over time, and the window of time, s.
const DRAWN: [usize; 3] = [0, 2, 4];
const FROM_S: f64 = 60.0;
const WINDOW_S: f64 = 8.0;

/// Most entrants that are drawn over time; more curves cannot be distinguished.
const MOST_TRACES: usize = 4;

/// The page of `table`, with pictures of `series`.
pub fn prediction_page(table: &PredictionTable, series: &Series) -> String {
    let mut body = "<h1>Residual prediction, a priori</h1>".to_owned();
    figures(&mut body, table);
    let _ = write!(body, "<h2>Error over the horizon</h2>");
    horizons(&mut body, &table.rows);
    body.push_str(&over_horizon(&table.rows).svg());
    for at in 0..DRAWN_STEPS.len() {
        for row in DRAWN {
            let _ = write!(body, "{}", over_time(table, series, row, at).svg());
        }
    }
    let _ = write!(
        body,
        "<h2>Made from</h2><p class=\"from\">{}<br>recording {} (seed {}), sha-256 {}<br>statistics of {}, hash {}</p>",
        escaped(&table.command),
        escaped(&table.recording.display().to_string()),
        escaped(&table.seed),
        table.recording_sha256,
        escaped(
            &table.training.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ")
        ),
        table.data_hash
    );
    markup::page("twin evaluate prediction", STYLE, &body)
}

/// A page with the HTML `body`, and the command that makes the page again.
pub fn pictures_page(title: &str, body: &str, command: &str) -> String {
    let (head, command) = (escaped(title), escaped(command));
    markup::page(title, STYLE, &format!("<h1>{head}</h1>{body}<p class=\"from\">{command}</p>"))
}

fn figures(page: &mut String, table: &PredictionTable) {
    let heads = COLUMNS.map(|column| format!("<th>{}</th>", column.name)).concat();
    let _ = write!(
        page,
        "<table><thead><tr><th>row</th><th>parameters</th>{heads}\
         <th>paper RMSE</th><th>R²</th><th>ms</th></tr></thead><tbody>",
    );
    for row in &table.rows {
        let figure = |Column { decimals, value, .. }: Column| cell(value(&row.replayed), decimals);
        let paper = row.paper.map_or_else(
            || "<td>–</td>".repeat(3),
            |paper| paper.map(|v| format!("<td>{v}</td>")).concat(),
        );
        let _ = write!(
            page,
            "<tr><td>{}</td><td>{}</td>{}{paper}</tr>",
            escaped(&row.label),
            row.parameters.map_or_else(|| "–".to_owned(), |n| n.to_string()),
            COLUMNS.map(figure).concat(),
        );
    }
    page.push_str("</tbody></table>");
    for s in &table.spreads {
        let at = s.horizons.iter().map(|at| {
            let ([rmse, rmse_std], [r2, r2_std]) = (at.rmse_z, at.r2);
            let j = at.j;
            format!("j = {j}: RMSE {rmse:.3} ± {rmse_std:.3}, R² {r2:.3} ± {r2_std:.3}")
        });
        let at = at.collect::<Vec<_>>().join("; ");
        let _ = write!(page, "<p>{} over {} trainings: {at}</p>", escaped(&s.name), s.trainings);
    }
}

/// A cell with a figure, or a dash where there is none.
fn cell(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "<td>–</td>".to_owned(), |v| format!("<td>{v:.decimals$}</td>"))
}

/// The table of errors by horizon.
fn horizons(page: &mut String, rows: &[Row]) {
    let shown = &MEASURES[..SHOWN_MEASURES];
    let heads =
        shown.iter().flat_map(|(name, _)| REPORTED.map(|j| format!("<th>{name}, j = {j}</th>")));
    let heads = heads.collect::<String>();
    let _ = write!(page, "<table><thead><tr><th>row</th>{heads}</tr></thead><tbody>");
    for row in rows {
        let of = |j: usize, value: fn(&Horizon) -> f64| cell(row.replayed.at(j).map(value), 3);
        let cells = shown.iter().flat_map(|(_, value)| REPORTED.map(|j| of(j, *value)));
        let cells = cells.collect::<String>();
        let _ = write!(page, "<tr><td>{}</td>{cells}</tr>", escaped(&row.label));
    }
    page.push_str("</tbody></table>");
}

fn over_horizon(rows: &[Row]) -> Picture {
    let curve = |row: &Row| Curve {
        measured: row.name == "persistence",
        ..horizon_curve(&row.label, row.replayed.horizons.iter().map(|h| h.rmse_z))
    };
    // With a larger range of the axis, the curves below 1 could not be distinguished.
    let best = |row: &&Row| row.replayed.at(0).is_some_and(|h| h.rmse_z < 1.0);
    let title = "RMSE, z-scored, of the predictors below 1";
    Picture::over_horizon(title, rows.iter().filter(best).map(curve))
}

/// The coordinate `row` over time, and its forecasts by step `at` of [`DRAWN_STEPS`].
fn over_time(table: &PredictionTable, series: &Series, row: usize, at: usize) -> Picture {
    let ahead = DRAWN_STEPS[at];
    let window = |t_s: f64| (FROM_S..FROM_S + WINDOW_S).contains(&t_s);
    let measured = Curve {
        name: "measured".to_owned(),
        points: series
            .samples
            .iter()
            .filter(|sample| window(sample.t_s))
            .map(|sample| (sample.t_s, sample.residual[row]))
            .collect(),
        measured: true,
    };
    let error = |row: &Row| row.replayed.at(ahead).map_or(f64::INFINITY, |h| h.rmse_z);
    let mut drawn: Vec<&Row> = table.rows.iter().filter(|row| error(row) < 1.0).collect();
    drawn.sort_by(|a, b| error(a).total_cmp(&error(b)));
    let curves = drawn.iter().take(MOST_TRACES).map(|entrant| Curve {
        name: entrant.label.clone(),
        points: series
            .samples
            .iter()
            .zip(&entrant.replayed.traces)
            .filter_map(|(sample, trace)| {
                Some((sample.t_s + ahead as f64 * TICK_S, trace[at]?[row]))
            })
            .filter(|(t_s, _)| window(*t_s))
            .collect(),
        measured: false,
    });
    Picture {
        title: format!("residual {}, forecast {ahead} ticks ahead", COORDINATE_NAMES[row]),
        x: "t, s".to_owned(),
        y: if row < 3 { "N" } else { "N m" }.to_owned(),
        curves: std::iter::once(measured).chain(curves).collect(),
        ..Picture::default()
    }
}
