//! The table as sheets: one with every figure for programs, and some for people.

use super::super::sheet::{Sheet, figure};
use super::bands::{BAND_NAMES, BANDS};
use super::foreseen::{At, Foreseen};
use super::foresight::MODEL_NAMES;
use super::table::{ResidualTable, Row, Share, Shares};
use super::variant::Variant;
use twin_core::notation::COORDINATE_NAMES;

/// Columns of the sheets of errors: the models in short, and the ratio of the windows.
const COLUMNS: [&str; MODEL_NAMES.len() + 1] = ["last", "10", "120", "÷"];

/// What these columns mean.
const LEGEND: &str = "model@ms ahead; last: the newest r; 10, 120: ridge regression on so many ticks; ÷: 120 divided by 10";

impl ResidualTable {
    /// Every figure, one a line: what it is, the effects that are off, coordinate, band, horizon, model, value and unit. A coordinate
    /// `all` is the mean over coordinates, and a band `all` is the sum of the bands.
    pub fn sheet(&self) -> Sheet {
        let head = ["figure", "variant", "row", "band", "ms ahead", "model", "value", "unit"];
        let mut sheet = Sheet::new(head);
        let mut add = |place: [&str; 6], value: f64, unit: &str| {
            let [what, variant, row, band, ms, model] = place.map(str::to_owned);
            let value = figure(Some(value), 6);
            sheet.rows.push(vec![what, variant, row, band, ms, model, value, unit.to_owned()]);
        };
        let on = Variant::On.words();
        for row in &self.rows {
            let squared = if row.unit == "N" { "N^2" } else { "N^2 m^2" };
            add(["mean", &on, row.row, "", "", ""], row.mean, row.unit);
            add(["variance", &on, row.row, "all", "", ""], row.variance, squared);
            for (band, value) in BAND_NAMES.iter().zip(row.band_variance) {
                add(["variance", &on, row.row, band, "", ""], value, squared);
            }
        }
        for shares in &self.effects {
            let words = shares.variant.words();
            add(["share", &words, "all", "all", "", ""], shares.total, "1");
            add(["deviation of share", &words, "all", "all", "", ""], shares.deviation, "1");
            for (row, share) in COORDINATE_NAMES.iter().zip(&shares.rows) {
                add(["share", &words, row, "all", "", ""], share.all, "1");
                for (band, value) in BAND_NAMES.iter().zip(share.bands) {
                    add(["share", &words, row, band, "", ""], value, "1");
                }
            }
        }
        for foreseen in &self.foresight {
            let words = foreseen.variant.words();
            for at in &foreseen.horizons {
                let ms = figure(Some(at.ms), 0);
                for (model, name) in MODEL_NAMES.iter().enumerate() {
                    add(["RMSE", &words, "all", "", &ms, name], at.rmse_z[model], "std");
                    for (row, value) in COORDINATE_NAMES.iter().zip(at.rows[model].iter()) {
                        add(["RMSE", &words, row, "", &ms, name], *value, "std");
                    }
                }
                add(["ratio", &words, "all", "", &ms, "120 / 10 ticks"], at.ratio, "1");
            }
        }
        sheet
    }

    /// The sheets for people, each with its title.
    pub fn sheets(&self) -> Vec<(String, Sheet)> {
        let titled = |title: &str, sheet| (title.to_owned(), sheet);
        let mut sheets = vec![titled(
            "Residual with everything on: mean, rms about the mean, rms by band; N and N m",
            bands(&self.rows),
        )];
        let share = "Variance that disappears without an effect, 1 - var(off)/var(on), %";
        sheets.push(titled(
            &format!("{share}; ± over the flights"),
            self.shares(|row| row.all, true),
        ));
        let of_band: [fn(&Share) -> f64; BANDS] = [|s| s.bands[0], |s| s.bands[1], |s| s.bands[2]];
        for (name, value) in BAND_NAMES.iter().zip(of_band) {
            sheets.push((format!("{share}; {name}"), self.shares(value, false)));
        }
        let errors = "RMSE of forecasts, z-scored";
        sheets.push((format!("{errors}, over all coordinates ({LEGEND})"), self.errors()));
        if let Some(on) = self.foresight.first() {
            sheets.push((format!("{errors}, everything on ({LEGEND})"), by_row(on)));
        }
        sheets
    }

    /// A line per effect: the mean over the coordinates, its deviation, and each coordinate, %.
    fn shares(&self, value: fn(&Share) -> f64, with_deviation: bool) -> Sheet {
        let deviation = with_deviation.then_some("±");
        let head = ["variant", "mean"].into_iter().chain(deviation).chain(COORDINATE_NAMES);
        let mut sheet = Sheet::new(head);
        // A zero added turns -0.0 into 0.0.
        let percent = |share: f64| figure(Some((1000.0 * share).round() / 10.0 + 0.0), 1);
        sheet.rows.extend(self.effects.iter().map(|shares: &Shares| {
            let each = shares.rows.iter().map(value);
            let mean = each.clone().sum::<f64>() / each.len() as f64;
            let deviation = with_deviation.then(|| percent(shares.deviation));
            let head = [shares.variant.words(), percent(mean)].into_iter().chain(deviation);
            head.chain(each.map(percent)).collect()
        }));
        sheet
    }

    /// A line per variant with the errors over all coordinates.
    fn errors(&self) -> Sheet {
        let line = |foreseen: &Foreseen| {
            cells(&foreseen.variant.words(), foreseen, &|at| at.rmse_z, &|at| at.ratio)
        };
        errors("variant", self.foresight.first(), self.foresight.iter().map(line))
    }
}

/// A line per coordinate with everything on.
fn bands(rows: &[Row]) -> Sheet {
    let bands = BAND_NAMES.iter().map(|name| format!("rms {name}"));
    let shares = BAND_NAMES.iter().map(|name| format!("% {name}"));
    let head = ["row", "unit", "mean", "rms"].map(str::to_owned);
    let mut sheet = Sheet::new(head.into_iter().chain(bands).chain(shares));
    sheet.rows.extend(rows.iter().map(|row| {
        let rms = |variance: f64| figure(Some(variance.sqrt()), 4);
        let mut cells = vec![row.row.to_owned(), row.unit.to_owned(), figure(Some(row.mean), 4)];
        cells.push(rms(row.variance));
        cells.extend(row.band_variance.map(rms));
        cells.extend(row.band_variance.map(|v| figure(Some(100.0 * v / row.variance), 1)));
        cells
    }));
    sheet
}

/// A line per coordinate with its errors.
fn by_row(on: &Foreseen) -> Sheet {
    let line = |(row, name): (usize, &&str)| {
        let rmse = |at: &At| at.rows.map(|rows| rows[row]);
        let ratio = |at: &At| at.rows[2][row] / at.rows[1][row];
        cells(name, on, &rmse, &ratio)
    };
    errors("row", Some(on), COORDINATE_NAMES.iter().enumerate().map(line))
}

/// Lines of errors: a name, each model at every horizon, and the ratio of the windows at every horizon.
fn errors(name: &str, like: Option<&Foreseen>, lines: impl Iterator<Item = Vec<String>>) -> Sheet {
    let heads = COLUMNS.iter().flat_map(|column| {
        let horizons = like.iter().flat_map(|like| &like.horizons);
        horizons.map(move |at| format!("{column}@{:.0}", at.ms))
    });
    let mut sheet = Sheet::new(std::iter::once(name.to_owned()).chain(heads));
    sheet.rows.extend(lines);
    sheet
}

/// The cells below the heads of [`errors`].
fn cells(
    name: &str,
    foreseen: &Foreseen,
    rmse: &dyn Fn(&At) -> [f64; MODEL_NAMES.len()],
    ratio: &dyn Fn(&At) -> f64,
) -> Vec<String> {
    let at = &foreseen.horizons;
    let models = (0..MODEL_NAMES.len()).flat_map(|model| at.iter().map(move |at| rmse(at)[model]));
    let values = models.chain(at.iter().map(ratio)).map(|value| figure(Some(value), 3));
    std::iter::once(name.to_owned()).chain(values).collect()
}

#[cfg(test)]
mod tests {
    use super::super::table::tests::table;

    #[test]
    fn every_sheet_is_rectangular_and_names_every_effect() {
        let table = table();
        let sheets = table.sheets();
        // Bands; shares in all and by band; errors by variant and by coordinate.
        assert_eq!(sheets.len(), 1 + 4 + 2);
        let whole = [("all figures".to_owned(), table.sheet())];
        for (title, sheet) in sheets.iter().chain(&whole) {
            assert!(sheet.rows.iter().all(|row| row.len() == sheet.head.len()), "{title}");
        }
        for (title, sheet) in &sheets[1..6] {
            for effect in ["without big", "without small", "everything off"] {
                assert!(sheet.rows.iter().any(|row| row[0] == effect), "{title}: {effect}");
            }
        }
        assert_eq!(sheets[1].1.rows[0][..4], ["without big", "50.0", "0.0", "50.0"]);
        let line = "ratio,without big,all,,60,120 / 10 ticks,1.000000,1\n";
        assert!(table.sheet().csv().contains(line), "{}", table.sheet().csv());
    }
}
