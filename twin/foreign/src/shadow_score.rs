//! Residuals and predictions of a mirrored flight, over the coordinates and ticks at which they are known.
//!
//! Every prediction is a priori: `base_j + W'_{t-1} g'_t`, made before `r_t` was seen, scored against `r_{t+j}`; persistence is
//! `r_{t-1}` for every `j`.

use std::collections::VecDeque;

use serde::Serialize;

use twin_core::elementary::squared;
use twin_core::notation::{COORDINATE_NAMES, Coords, KnownMask, N, known_in_both};
use twin_core::residual::REPORTED;
use twin_core::residual::foresight::a_priori;
use twin_core::tick::Tick;

/// Results per coordinate and per horizon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scored {
    /// Results of each coordinate, in coordinate order.
    pub rows: Vec<RowReport>,
    /// Errors by horizon, `j = 0..=k`.
    pub prediction: Vec<HorizonReport>,
}

/// Results of one coordinate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RowReport {
    /// Name of the coordinate.
    pub row: &'static str,
    /// Share of ticks at which the coordinate is known.
    pub coordinate_known: f64,
    /// Share of ticks at which the residual is known in the air; 0 says that it is never known, not that it is zero.
    pub residual_known: f64,
    /// Statistics of the residual; absent if it is never known.
    pub residual: Option<ResidualReport>,
}

/// Statistics of a residual, in `unit`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ResidualReport {
    /// N or N m.
    pub unit: &'static str,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
}

/// Errors at one horizon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HorizonReport {
    /// Number of ticks ahead.
    pub j: usize,
    /// Root mean square error over known coordinates and ticks, in standard deviations of each coordinate's residual.
    pub rmse_z: Option<f64>,
    /// The same error of the persistence forecast.
    pub persistence_rmse_z: Option<f64>,
    /// Number of forecasts that were scored.
    pub samples: usize,
}

#[derive(Clone, Copy)]
struct Sum {
    count: f64,
    total: f64,
    squares: f64,
    min: f64,
    max: f64,
}

const EMPTY: Sum = Sum { count: 0.0, total: 0.0, squares: 0.0, min: f64::MAX, max: f64::MIN };

/// A forecast that waits for the residual it predicts.
struct Pending {
    ahead: Vec<Coords>,
    persistence: Coords,
    known: KnownMask,
}

/// Collects the statistics tick by tick.
pub(super) struct Score {
    scale: Coords,
    /// Number of ticks at which each coordinate is known.
    coordinates: [usize; N],
    rows: [Sum; N],
    /// Sums of squared errors of the forecast and of persistence at each of [`REPORTED`], and their numbers.
    squares: [[f64; 2]; REPORTED.len()],
    samples: [usize; REPORTED.len()],
    pending: VecDeque<Pending>,
    last: Option<(Coords, KnownMask)>,
}

impl Score {
    /// An empty score; `scale` is the standard deviation of each coordinate's residual, N and N m.
    pub(super) fn new(scale: Coords) -> Self {
        Self {
            scale,
            coordinates: [0; N],
            rows: [EMPTY; N],
            squares: [[0.0; 2]; REPORTED.len()],
            samples: [0; REPORTED.len()],
            pending: VecDeque::new(),
            last: None,
        }
    }

    /// Adds one tick.
    pub(super) fn add(&mut self, tick: &Tick) {
        let (r, known) = (*tick.residual, tick.residual.known());
        self.coordinates
            .iter_mut()
            .zip(tick.measurement.chi.known())
            .for_each(|(n, known)| *n += usize::from(known));
        for row in (0..N).filter(|row| known[*row]) {
            let sum = &mut self.rows[row];
            sum.count += 1.0;
            sum.total += r[row];
            sum.squares += r[row] * r[row];
            sum.min = sum.min.min(r[row]);
            sum.max = sum.max.max(r[row]);
        }
        if let Some((persistence, was_known)) = self.last {
            self.pending.push_front(Pending {
                ahead: a_priori(&tick.forecast, &tick.adapted),
                persistence,
                known: known_in_both(was_known, known),
            });
        } else {
            self.pending.clear();
        }
        self.pending.truncate(REPORTED[REPORTED.len() - 1] + 1);
        for (at, j) in REPORTED.into_iter().enumerate() {
            let Some(made) = self.pending.get(j) else { continue };
            let Some(forecast) = made.ahead.get(j) else { continue };
            for row in (0..N).filter(|row| known[*row] && made.known[*row]) {
                let z = |error: f64| squared(error / self.scale[row]);
                self.squares[at][0] += z(r[row] - forecast[row]);
                self.squares[at][1] += z(r[row] - made.persistence[row]);
                self.samples[at] += 1;
            }
        }
        self.last = Some((r, known));
    }

    /// The results of a flight of `ticks` ticks.
    pub(super) fn finish(self, ticks: usize) -> Scored {
        let ticks = ticks.max(1) as f64;
        let rows = (0..N).map(|row| {
            let sum = self.rows[row];
            let mean = sum.total / sum.count.max(1.0);
            RowReport {
                row: COORDINATE_NAMES[row],
                coordinate_known: self.coordinates[row] as f64 / ticks,
                residual_known: sum.count / ticks,
                residual: (sum.count > 0.0).then(|| ResidualReport {
                    unit: unit(row),
                    mean,
                    std: (sum.squares / sum.count - mean * mean).max(0.0).sqrt(),
                    min: sum.min,
                    max: sum.max,
                }),
            }
        });
        let prediction = REPORTED.into_iter().enumerate().map(|(at, j)| {
            let root =
                |sum: f64| (self.samples[at] > 0).then(|| (sum / self.samples[at] as f64).sqrt());
            HorizonReport {
                j,
                rmse_z: root(self.squares[at][0]),
                persistence_rmse_z: root(self.squares[at][1]),
                samples: self.samples[at],
            }
        });
        Scored { rows: rows.collect(), prediction: prediction.collect() }
    }
}

/// Unit of a coordinate's residual.
fn unit(row: usize) -> &'static str {
    if matches!(COORDINATE_NAMES[row], "x" | "y" | "z") { "N" } else { "N m" }
}
