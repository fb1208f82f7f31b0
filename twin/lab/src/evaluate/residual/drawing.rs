//! The pictures of the table: bands, shares of the effects, errors of the forecasts.

use super::super::bars::Bars;
use super::super::pictures::{Curve, Picture};
use super::bands::BAND_NAMES;
use super::foreseen::Foreseen;
use super::foresight::MODEL_NAMES;
use super::table::{ResidualTable, Row, Shares};
use super::variant::Variant;
use twin_core::notation::COORDINATE_NAMES;

/// Most variants whose ratio is drawn; the picture has no more colours.
const MOST_RATIOS: usize = 6;

/// The pictures of `table` as HTML.
pub fn pictures(table: &ResidualTable) -> String {
    let mut text = "<h2>Bands of the residual, everything on</h2>".to_owned();
    text.push_str(&composition(&table.rows).svg());
    text.push_str("<h2>Share of the variance that disappears without an effect</h2>");
    for shares in &table.effects {
        text.push_str(&of_effect(shares).svg());
    }
    text.push_str("<h2>Errors of forecasts</h2>");
    let first = table.foresight.first();
    text.extend(first.map(|on| errors(on).svg()));
    text.push_str(&ratios(&table.foresight).svg());
    text
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// The share of each band in the variance of each coordinate.
fn composition(rows: &[Row]) -> Bars {
    let share = |band: usize| {
        rows.iter().map(|row| 100.0 * row.band_variance[band] / row.variance).collect()
    };
    let series = |(band, name): (usize, &&str)| ((*name).to_owned(), share(band));
    Bars {
        title: "variance by band".to_owned(),
        y: "%".to_owned(),
        groups: rows.iter().map(|row| row.row.to_owned()).collect(),
        series: BAND_NAMES.iter().enumerate().map(series).collect(),
        stacked: true,
    }
}

/// The share of the variance of each band that disappears without an effect.
fn of_effect(shares: &Shares) -> Bars {
    let share = |band: usize| shares.rows.iter().map(|row| 100.0 * row.bands[band]).collect();
    let series = |(band, name): (usize, &&str)| ((*name).to_owned(), share(band));
    Bars {
        title: format!("{}: {:.1} % in all", shares.variant.words(), 100.0 * shares.total),
        y: "%".to_owned(),
        groups: names(&COORDINATE_NAMES),
        series: BAND_NAMES.iter().enumerate().map(series).collect(),
        stacked: false,
    }
}

/// The errors of the models over the horizon.
fn errors(on: &Foreseen) -> Picture {
    let curve = |(model, name): (usize, &&str)| Curve {
        name: (*name).to_owned(),
        points: on.horizons.iter().map(|at| (at.ms, at.rmse_z[model])).collect(),
        measured: model == 0,
    };
    Picture {
        title: "RMSE, z-scored, everything on".to_owned(),
        x: "ms ahead".to_owned(),
        y: "RMSE".to_owned(),
        curves: MODEL_NAMES.iter().enumerate().map(curve).collect(),
        ..Picture::default()
    }
}

/// The ratio of the windows over the horizon: with everything on, and without the effects that raise it most.
fn ratios(foresight: &[Foreseen]) -> Picture {
    let (on, mut others): (Vec<&Foreseen>, Vec<&Foreseen>) =
        foresight.iter().partition(|foreseen| foreseen.variant == Variant::On);
    others.sort_by(|a, b| b.ratio().total_cmp(&a.ratio()));
    let curve = |foreseen: &&Foreseen| Curve {
        name: foreseen.variant.words(),
        points: foreseen.horizons.iter().map(|at| (at.ms, at.ratio)).collect(),
        measured: foreseen.variant == Variant::On,
    };
    Picture {
        title: "RMSE with 120 ticks divided by RMSE with 10 ticks".to_owned(),
        x: "ms ahead".to_owned(),
        y: "ratio".to_owned(),
        curves: on.iter().chain(others.iter().take(MOST_RATIOS)).map(curve).collect(),
        ..Picture::default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::tests::table;
    use super::*;

    #[test]
    fn the_pictures_show_every_effect_band_and_model() {
        let text = pictures(&table());
        assert_eq!(text.matches("<svg").count(), 1 + 3 + 2);
        for word in
            ["without big: 50.0 %", "without small", "everything off", "120 ticks", "> 2 Hz"]
        {
            let escaped = word.replace('>', "&gt;");
            assert!(text.contains(word) || text.contains(&escaped), "{word}");
        }
    }
}
