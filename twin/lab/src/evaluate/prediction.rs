//! The prediction table: every entrant over one recording, with its errors by horizon and the figures of the paper.

use std::path::PathBuf;

use serde::Serialize;

use super::entrants::{Candidate, Paper};
use super::replay::{Replayed, replay};
use super::score::Horizon;
use super::series::{Series, Statistics};
use super::sheet::{Sheet, figure};
use twin_core::elementary::squared;
use twin_core::residual::HORIZON;

/// A line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Name for `--models` and for JSON.
    pub name: String,
    /// Label that people read.
    pub label: String,
    /// Number of learned parameters; `None` if nothing was learned.
    pub parameters: Option<usize>,
    /// Hash of the training data, from the file of weights.
    pub trained_on: Option<String>,
    /// File of weights.
    pub weights: Option<PathBuf>,
    /// RMSE, R² and ms of the paper.
    pub paper: Paper,
    /// Result of the replay.
    #[serde(flatten)]
    pub replayed: Replayed,
}

/// A figure of a line, as the page and the terminal show it.
pub struct Column {
    /// Its name on the page.
    pub name: &'static str,
    /// Its name in the terminal.
    pub short: &'static str,
    /// Decimals.
    pub decimals: usize,
    /// The figure.
    pub value: fn(&Replayed) -> f64,
}

impl Column {
    const fn new(
        name: &'static str,
        short: &'static str,
        decimals: usize,
        value: fn(&Replayed) -> f64,
    ) -> Self {
        Self { name, short, decimals, value }
    }
}

/// The figures of a line, in order. The sheet holds the figures of every horizon.
pub const COLUMNS: [Column; 10] = [
    Column::new("RMSE z", "RMSE z", 3, |r| r.horizons[0].rmse_z),
    Column::new("R²", "R²", 3, |r| r.horizons[0].r2),
    Column::new("RMSE z, j = 6", "j=6", 3, |r| r.horizons[HORIZON].rmse_z),
    Column::new("R², j = 6", "R² j=6", 3, |r| r.horizons[HORIZON].r2),
    Column::new("N", "N", 3, |r| r.horizons[0].rmse_n),
    Column::new("N m", "N m", 4, |r| r.horizons[0].rmse_n_m),
    Column::new("‖ε‖", "|eps|", 3, |r| r.innovation_norm_mean),
    Column::new("leverage", "leverage", 3, |r| r.leverage),
    Column::new("ms p50", "ms p50", 3, |r| r.inference_ms_p50),
    Column::new("p99", "p99", 3, |r| r.inference_ms_p99),
];

/// A figure of one horizon, with its name in the sheet.
type Measure = (&'static str, fn(&Horizon) -> f64);

/// The figures that the sheet holds for every horizon.
const MEASURES: [Measure; 4] = [
    ("RMSE z", |h| h.rmse_z),
    ("R²", |h| h.r2),
    ("RMSE N", |h| h.rmse_n),
    ("RMSE N m", |h| h.rmse_n_m),
];

/// A model that was trained with several seeds: mean and standard deviation (n - 1) over the trainings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Name of its lines.
    pub name: String,
    /// Number of trainings.
    pub trainings: usize,
    /// z-scored RMSE at `j = 0`.
    pub rmse_z: [f64; 2],
    /// R² at `j = 0`.
    pub r2: [f64; 2],
    /// z-scored RMSE at `j = k`.
    pub rmse_z_last: [f64; 2],
}

/// The spread of every model and size that has more than one line, in the order of the lines.
pub fn spreads(rows: &[Row]) -> Vec<Spread> {
    let kind = |row: &Row| (row.name.clone(), row.parameters);
    let mut kinds = Vec::new();
    for row in rows {
        if !kinds.contains(&kind(row)) {
            kinds.push(kind(row));
        }
    }
    let of = |one: (String, Option<usize>)| -> Option<Spread> {
        let same: Vec<&Row> = rows.iter().filter(|row| kind(row) == one).collect();
        let over = |value: fn(&Replayed) -> f64| {
            let n = same.len() as f64;
            let values = || same.iter().map(|row| value(&row.replayed));
            let mean = values().sum::<f64>() / n;
            let squares = values().map(|v| squared(v - mean)).sum::<f64>();
            [mean, (squares / (n - 1.0)).sqrt()]
        };
        (same.len() > 1).then(|| Spread {
            name: one.0,
            trainings: same.len(),
            rmse_z: over(|r| r.horizons[0].rmse_z),
            r2: over(|r| r.horizons[0].r2),
            rmse_z_last: over(|r| r.horizons[HORIZON].rmse_z),
        })
    };
    kinds.into_iter().filter_map(of).collect()
}

/// The table, with the sources that it was made from.
#[derive(Clone, Debug, Serialize)]
pub struct PredictionTable {
    /// Always `prediction`.
    pub table: &'static str,
    /// The command that makes it again.
    pub command: String,
    /// The recording.
    pub recording: PathBuf,
    /// Sha-256 of the recording.
    pub recording_sha256: String,
    /// Seed of the recorded flight.
    pub seed: String,
    /// The training recordings; their statistics z-score all figures.
    pub training: Vec<PathBuf>,
    /// Hash of the training recordings.
    pub data_hash: String,
    /// Mean and standard deviation of inputs and residual over the training recordings.
    pub statistics: Statistics,
    /// The lines.
    pub rows: Vec<Row>,
    /// Mean and standard deviation over trainings with several seeds.
    pub spreads: Vec<Spread>,
}

impl PredictionTable {
    /// The table as plain cells, with every horizon.
    pub fn sheet(&self) -> Sheet {
        let head = ["row", "label", "parameters", "weights", "trained on"];
        let horizons = MEASURES
            .iter()
            .flat_map(|(name, _)| (0..=HORIZON).map(move |j| format!("{name}, j = {j}")));
        let tail = ["leverage", "resets", "ms p50", "ms p99", "paper RMSE", "paper R²", "paper ms"];
        let own = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let mut sheet = Sheet::new(own(&head).into_iter().chain(horizons).chain(own(&tail)));
        sheet.rows.extend(self.rows.iter().map(Row::cells));
        sheet
    }
}

impl Row {
    fn cells(&self) -> Vec<String> {
        let r = &self.replayed;
        let known = |text: &Option<String>| text.clone().unwrap_or_default();
        let mut cells = vec![
            self.name.clone(),
            self.label.clone(),
            self.parameters.map_or_else(String::new, |n| n.to_string()),
            self.weights.as_ref().map_or_else(String::new, |file| file.display().to_string()),
            known(&self.trained_on),
        ];
        for (_, value) in MEASURES {
            cells.extend(r.horizons.iter().map(|h| figure(Some(value(h)), 4)));
        }
        cells.extend([figure(Some(r.leverage), 3), r.resets.to_string()]);
        cells.extend([r.inference_ms_p50, r.inference_ms_p99].map(|ms| figure(Some(ms), 3)));
        cells.extend((0..3).map(|i| figure(self.paper.map(|paper| paper[i]), 3)));
        cells
    }
}

/// Replays `series` through the candidates, one after the other, so that their times can be compared. `done` gets the name of each
/// when it ends.
pub fn rows(
    candidates: Vec<Candidate>,
    series: &Series,
    statistics: &Statistics,
    done: &dyn Fn(&str),
) -> Vec<Row> {
    let mut rows = Vec::new();
    for mut candidate in candidates {
        let replayed = replay(&mut candidate.entrant, series, statistics);
        done(&candidate.name);
        let Candidate { name, label, parameters, trained_on, weights, paper, .. } = candidate;
        rows.push(Row { name, label, parameters, trained_on, weights, paper, replayed });
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::notation::Coords;

    fn row(parameters: usize, rmse_z: f64) -> Row {
        let horizon = |j| Horizon {
            j,
            rmse_z,
            r2: 1.0 - rmse_z,
            rmse_n: 0.0,
            rmse_n_m: 0.0,
            rmse_rows: Coords::zeros(),
            samples: 1,
        };
        Row {
            name: "fdt".to_owned(),
            label: "FDT".to_owned(),
            parameters: Some(parameters),
            trained_on: None,
            weights: None,
            paper: None,
            replayed: Replayed {
                horizons: (0..=HORIZON).map(horizon).collect(),
                innovation_norm_mean: 0.0,
                innovation_mean_q999: 0.0,
                leverage: 0.0,
                resets: 0,
                inference_ms_p50: 0.0,
                inference_ms_p99: 0.0,
                traces: Vec::new(),
            },
        }
    }

    #[test]
    fn the_spread_is_over_trainings_of_one_size_alone() {
        let found = spreads(&[row(10, 0.1), row(99, 0.9), row(10, 0.3)]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].trainings, 2);
        // Mean and standard deviation (n - 1) of 0.1 and 0.3, within rounding.
        let [mean, deviation] = found[0].rmse_z;
        assert!((mean - 0.2).abs() < 1e-12 && (deviation - 0.02_f64.sqrt()).abs() < 1e-12);
    }
}
