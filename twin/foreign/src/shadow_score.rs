//! Residuals and predictions of a mirrored flight, over the coordinates and ticks at which they are known.
//!
//! Every prediction is a priori: `base_j + W'_{t-1} g'_t`, made before `r_t` was seen, scored against `r_{t+j}`; persistence is
//! `r_{t-1}` for every `j`, and the mean is that of the scored residuals, which nobody knew in flight.

use std::collections::VecDeque;

use serde::Serialize;

use twin_core::elementary::{exp, squared};
use twin_core::notation::{
    COORDINATE_NAMES, Coords, KnownCoords, KnownMask, N, TICK_S, known_in_both,
};
use twin_core::residual::foresight::{BAND_90, Errors, MEMORY_S, a_priori};
use twin_core::tick::Tick;

/// The steps `j` whose forecasts are scored, ticks: each of the paper's horizon, and two of the longer one.
pub const SCORED: [usize; 9] = [0, 1, 2, 3, 4, 5, 6, 10, 20];

/// Results per coordinate and per horizon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scored {
    /// Results of each coordinate, in coordinate order.
    pub rows: Vec<RowReport>,
    /// Errors at each of [`SCORED`].
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
    /// The same error of the mean of the scored residuals.
    pub mean_rmse_z: Option<f64>,
    /// Whether the forecast errs less than persistence.
    pub better_than_persistence: Option<bool>,
    /// Whether the forecast errs less than the mean.
    pub better_than_mean: Option<bool>,
    /// Share of residuals inside the band that the forecast's earlier errors gave it; 0.9 is aimed at.
    pub band_90_holds: Option<f64>,
    /// Mean half width of that band, in standard deviations of each coordinate's residual.
    pub band_90_z: Option<f64>,
    /// Number of forecasts that were scored.
    pub samples: usize,
}

#[derive(Clone, Copy, Debug)]
struct Sum {
    count: f64,
    total: f64,
    squares: f64,
    min: f64,
    max: f64,
}

const EMPTY: Sum = Sum { count: 0.0, total: 0.0, squares: 0.0, min: f64::MAX, max: f64::MIN };

/// A forecast that waits for the residual it predicts.
#[derive(Debug)]
struct Pending {
    ahead: Vec<Coords>,
    persistence: Coords,
    known: KnownMask,
    /// Predictive standard deviation at each of [`SCORED`], as z-scores.
    std: [KnownCoords; SCORED.len()],
}

/// Sums over the forecasts of one horizon, as z-scores.
#[derive(Clone, Debug, Default)]
struct Horizon {
    samples: usize,
    /// Squared errors of the forecast and of persistence.
    squares: [f64; 2],
    /// Number, sum and sum of squares of the residuals of each coordinate, for the error of their mean.
    residuals: [[f64; 3]; N],
    /// Errors of the last seconds, as z-scores, for the band.
    errors: Errors,
    /// Number of forecasts with a band, number of residuals inside it, and sum of its half widths.
    band: [f64; 3],
}

impl Horizon {
    /// Adds the residual `r` of coordinate `row`, whose forecast, persistence and band (half width) were made before; all are z-scores.
    fn add(&mut self, row: usize, r: f64, forecast: f64, persistence: f64, band: Option<f64>) {
        self.samples += 1;
        self.squares[0] += squared(r - forecast);
        self.squares[1] += squared(r - persistence);
        let [count, sum, square] = &mut self.residuals[row];
        (*count, *sum, *square) = (*count + 1.0, *sum + r, *square + r * r);
        self.errors.add(row, r - forecast, exp(-TICK_S / MEMORY_S));
        if let Some(half_width) = band {
            let inside = f64::from(u8::from((r - forecast).abs() <= half_width));
            self.band = [self.band[0] + 1.0, self.band[1] + inside, self.band[2] + half_width];
        }
    }

    fn report(&self, j: usize) -> HorizonReport {
        let root =
            |sum: f64| (self.samples > 0).then(|| (sum / self.samples as f64).max(0.0).sqrt());
        let about_mean =
            |[count, sum, square]: &[f64; 3]| square - sum * sum / f64::max(*count, 1.0);
        let [rmse_z, persistence_rmse_z] = self.squares.map(root);
        let mean_rmse_z = root(self.residuals.iter().map(about_mean).sum());
        let better = |other: Option<f64>| Some(rmse_z? < other?);
        let share = |sum: f64| (self.band[0] > 0.0).then(|| sum / self.band[0]);
        HorizonReport {
            j,
            rmse_z,
            persistence_rmse_z,
            mean_rmse_z,
            better_than_persistence: better(persistence_rmse_z),
            better_than_mean: better(mean_rmse_z),
            band_90_holds: share(self.band[1]),
            band_90_z: share(self.band[2]),
            samples: self.samples,
        }
    }
}

/// Collects the statistics tick by tick.
#[derive(Debug)]
pub struct Score {
    scale: Coords,
    /// Number of ticks at which each coordinate is known.
    coordinates: [usize; N],
    rows: [Sum; N],
    horizons: [Horizon; SCORED.len()],
    pending: VecDeque<Pending>,
    last: Option<(Coords, KnownMask)>,
}

impl Score {
    /// An empty score; `scale` is the standard deviation of each coordinate's residual, N and N m.
    pub fn new(scale: Coords) -> Self {
        Self {
            scale,
            coordinates: [0; N],
            rows: [EMPTY; N],
            horizons: Default::default(),
            pending: VecDeque::new(),
            last: None,
        }
    }

    /// Adds one tick.
    pub fn add(&mut self, tick: &Tick) {
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
                std: std::array::from_fn(|at| self.horizons[at].errors.std()),
            });
        } else {
            self.pending.clear();
        }
        self.pending.truncate(SCORED[SCORED.len() - 1] + 1);
        for (horizon, (at, j)) in self.horizons.iter_mut().zip(SCORED.into_iter().enumerate()) {
            let Some(made) = self.pending.get(j) else { continue };
            let Some(forecast) = made.ahead.get(j) else { continue };
            for row in (0..N).filter(|row| known[*row] && made.known[*row]) {
                let z = |value: f64| value / self.scale[row];
                let band = made.std[at].get(row).map(|std| BAND_90 * std);
                let (forecast, persistence) = (z(forecast[row]), z(made.persistence[row]));
                horizon.add(row, z(r[row]), forecast, persistence, band);
            }
        }
        self.last = Some((r, known));
    }

    /// Errors of the forecasts so far, at each of [`SCORED`].
    pub fn prediction(&self) -> Vec<HorizonReport> {
        self.horizons.iter().zip(SCORED).map(|(horizon, j)| horizon.report(j)).collect()
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
        let prediction = self.prediction();
        Scored { rows: rows.collect(), prediction }
    }
}

/// Unit of a coordinate's residual.
fn unit(row: usize) -> &'static str {
    if matches!(COORDINATE_NAMES[row], "x" | "y" | "z") { "N" } else { "N m" }
}
