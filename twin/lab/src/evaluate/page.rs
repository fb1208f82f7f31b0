//! The prediction table as one page that opens offline: figures, pictures, and the sources of both.

use std::fmt::Write;

use super::pictures::{Curve, Picture, horizon_curve};
use super::prediction::{COLUMNS, Column, PredictionTable, Row};
use super::series::Series;
use twin_core::notation::{COORDINATE_NAMES, TICK_S};
use twin_core::residual::HORIZON;
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
    let _ = write!(body, "<h2>Error over the horizon</h2>{}", over_horizon(&table.rows).svg());
    for at in [0, HORIZON] {
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
        let figure = |Column { decimals, value, .. }: Column| {
            format!("<td>{:.decimals$}</td>", value(&row.replayed))
        };
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
        let _ = write!(
            page,
            "<p>{} over {} trainings: RMSE {:.3} ± {:.3}, R² {:.3} ± {:.3}</p>",
            escaped(&s.name),
            s.trainings,
            s.rmse_z[0],
            s.rmse_z[1],
            s.r2[0],
            s.r2[1],
        );
    }
}

fn over_horizon(rows: &[Row]) -> Picture {
    let curve = |row: &Row| Curve {
        measured: row.name == "persistence",
        ..horizon_curve(&row.label, row.replayed.horizons.iter().map(|h| h.rmse_z))
    };
    // With a larger range of the axis, the curves below 1 could not be distinguished.
    let best = |row: &&Row| row.replayed.horizons[0].rmse_z < 1.0;
    let title = "RMSE, z-scored, of the predictors below 1";
    Picture::over_horizon(title, rows.iter().filter(best).map(curve))
}

fn over_time(table: &PredictionTable, series: &Series, row: usize, at: usize) -> Picture {
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
    let mut drawn: Vec<&Row> =
        table.rows.iter().filter(|row| row.replayed.horizons[at].rmse_z < 1.0).collect();
    drawn.sort_by(|a, b| a.replayed.horizons[at].rmse_z.total_cmp(&b.replayed.horizons[at].rmse_z));
    let curves = drawn.iter().take(MOST_TRACES).map(|entrant| Curve {
        name: entrant.label.clone(),
        points: series
            .samples
            .iter()
            .zip(&entrant.replayed.traces)
            .map(|(sample, trace)| {
                (sample.t_s + at as f64 * TICK_S, trace[usize::from(at > 0)][row])
            })
            .filter(|(t_s, _)| window(*t_s))
            .collect(),
        measured: false,
    });
    Picture {
        title: format!("residual {}, forecast {at} ticks ahead", COORDINATE_NAMES[row]),
        x: "t, s".to_owned(),
        y: if row < 3 { "N" } else { "N m" }.to_owned(),
        curves: std::iter::once(measured).chain(curves).collect(),
        ..Picture::default()
    }
}
