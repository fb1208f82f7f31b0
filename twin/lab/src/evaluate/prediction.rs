//! The prediction table: every entrant over one recording, with its errors by horizon and the figures of the paper.

use std::path::PathBuf;

use serde::Serialize;

use super::entrants::{Candidate, Paper};
use super::replay::{Replayed, replay};
use super::score::Horizon;
use super::series::{Series, Statistics};
use super::sheet::{Sheet, figure};
use twin_core::elementary::squared;
use twin_core::residual::REPORTED;

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
    /// The figure; `None` if the line has none.
    pub value: fn(&Replayed) -> Option<f64>,
}

impl Column {
    const fn new(
        name: &'static str,
        short: &'static str,
        decimals: usize,
        value: fn(&Replayed) -> Option<f64>,
    ) -> Self {
        Self { name, short, decimals, value }
    }
}

/// The figures of a line at `j = 0`, in order. [`MEASURES`] has those of the later steps.
pub const COLUMNS: [Column; 8] = [
    Column::new("RMSE z", "RMSE z", 3, |r| r.at(0).map(|h| h.rmse_z)),
    Column::new("R²", "R²", 3, |r| r.at(0).map(|h| h.r2)),
    Column::new("N", "N", 3, |r| r.at(0).map(|h| h.rmse_n)),
    Column::new("N m", "N m", 4, |r| r.at(0).map(|h| h.rmse_n_m)),
    Column::new("‖ε‖", "|eps|", 3, |r| Some(r.innovation_norm_mean)),
    Column::new("leverage", "leverage", 3, |r| Some(r.leverage)),
    Column::new("ms p50", "ms p50", 3, |r| Some(r.inference_ms_p50)),
    Column::new("p99", "p99", 3, |r| Some(r.inference_ms_p99)),
];

/// A figure of one horizon, with its name.
pub type Measure = (&'static str, fn(&Horizon) -> f64);

/// The figures of each of [`REPORTED`]; the terminal and the page show the first [`SHOWN_MEASURES`].
pub const MEASURES: [Measure; 4] = [
    ("RMSE z", |h| h.rmse_z),
    ("R²", |h| h.r2),
    ("RMSE N", |h| h.rmse_n),
    ("RMSE N m", |h| h.rmse_n_m),
];

/// Number of [`MEASURES`] that the terminal and the page show.
pub const SHOWN_MEASURES: usize = 2;

/// A model that was trained with several seeds: mean and standard deviation (n - 1) over the trainings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Name of its lines.
    pub name: String,
    /// Number of trainings.
    pub trainings: usize,
    /// The figures at each of [`REPORTED`] that the horizon of the model reaches.
    pub horizons: Vec<SpreadAt>,
}

/// The spread at one horizon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpreadAt {
    /// Ticks ahead.
    pub j: usize,
    /// z-scored RMSE.
    pub rmse_z: [f64; 2],
    /// R².
    pub r2: [f64; 2],
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
        let over = |j: usize, value: fn(&Horizon) -> f64| -> Option<[f64; 2]> {
            let n = same.len() as f64;
            let values: Option<Vec<f64>> =
                same.iter().map(|row| row.replayed.at(j).map(value)).collect();
            let values = values?;
            let mean = values.iter().sum::<f64>() / n;
            let squares = values.iter().map(|v| squared(v - mean)).sum::<f64>();
            Some([mean, (squares / (n - 1.0)).sqrt()])
        };
        let at = |j| Some(SpreadAt { j, rmse_z: over(j, |h| h.rmse_z)?, r2: over(j, |h| h.r2)? });
        let horizons = || REPORTED.into_iter().filter_map(at).collect();
        (same.len() > 1).then(|| Spread {
            name: one.0,
            trainings: same.len(),
            horizons: horizons(),
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
    /// The table as plain cells, with every reported horizon.
    pub fn sheet(&self) -> Sheet {
        let head = ["row", "label", "parameters", "weights", "trained on"];
        let horizons =
            MEASURES.iter().flat_map(|(name, _)| REPORTED.map(|j| format!("{name}, j = {j}")));
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
            cells.extend(REPORTED.map(|j| figure(r.at(j).map(value), 4)));
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
                horizons: (0..=6).map(horizon).collect(),
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
        let [mean, deviation] = found[0].horizons[0].rmse_z;
        assert!((mean - 0.2).abs() < 1e-12 && (deviation - 0.02_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_line_has_no_figure_beyond_its_horizon() {
        let found = spreads(&[row(10, 0.1), row(10, 0.3)]);
        let steps: Vec<usize> = found[0].horizons.iter().map(|at| at.j).collect();
        assert_eq!(steps, [0, 3, 6]);
        let cells = row(10, 0.1).cells();
        let rmse: Vec<&str> = cells[5..5 + REPORTED.len()].iter().map(String::as_str).collect();
        assert_eq!(rmse, ["0.1000", "0.1000", "0.1000", "", ""]);
    }
}
