//! The result of flying the twin beside a recording: its error per axis and horizon, and whether its prediction is valid.

use serde::Serialize;
use ts_rs::TS;

use twin_core::notation::{COORDINATE_NAMES, TICK_S};

/// Horizons in ticks at which twin and recorded flight are compared: 0.1, 0.5 and 1 s.
pub const HORIZONS: [usize; 3] = [10, 50, 100];

/// Number of coordinates that are compared: those of the base.
pub const AXES: usize = 6;

/// One number per coordinate of the base, m and rad.
pub(super) type Axis = [f64; AXES];

/// Accuracy of the recorded motion over a second, m or rad: motion capture, and the slope of its poses over 80 ms, are no more
/// accurate than this.
const FLOOR: f64 = 0.02;

/// Largest ratio of the twin's error to the coasting error at which the twin counts as valid.
const GOOD_SHARE: f64 = 0.5;

/// One flight of the twin from one point of the recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TwinFlight {
    /// Start of the flight, s of the recording.
    pub t_s: f64,
    /// True if the torque is known and the twin flies its own attitude; false if it follows the recorded attitude.
    pub free: bool,
    /// Errors per horizon and coordinate.
    pub after: [[PredictionError; AXES]; HORIZONS.len()],
}

/// Distance from the recorded flight after one horizon, m or rad; `None` where it is not compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PredictionError {
    /// Error of the twin.
    pub twin: Option<f64>,
    /// Error of the twin with the residual that was measured before the start.
    pub with_residual: Option<f64>,
    /// Error of coasting: the vehicle continues with its velocity at the start.
    pub coasting: Option<f64>,
}

/// Verdict on the twin's prediction, relative to coasting and to the accuracy of the recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum Light {
    /// The twin's error is below half of the coasting error, or below the accuracy of the recording.
    Valid,
    /// The twin's error is below the coasting error, or below twice the accuracy of the recording.
    Doubtful,
    /// Coasting predicts the motion better than the twin.
    Invalid,
}

impl Light {
    /// Verdict on `error` by comparison with the error of `coasting`, both m or rad.
    pub fn of(error: f64, coasting: f64) -> Self {
        let (error, coasting) = (error.abs(), coasting.abs());
        if error <= (GOOD_SHARE * coasting).max(FLOOR) {
            Self::Valid
        } else if error <= coasting.max(2.0 * FLOOR) {
            Self::Doubtful
        } else {
            Self::Invalid
        }
    }

    /// Worst verdict over the coordinates that were compared; `None` if none was.
    pub fn worst(misses: &[PredictionError; AXES]) -> Option<Self> {
        misses.iter().filter_map(|m| Some(Self::of(m.twin?, m.coasting?))).max()
    }
}

/// Summary of all flights of the twin along a recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the vehicle that the twin flew.
    pub twin: String,
    /// The commands that the twin received, in words.
    pub commands: &'static str,
    /// Number of flights.
    pub flights: usize,
    /// Errors per horizon.
    pub horizons: Vec<Horizon>,
    /// Worst verdict over the axes at the second horizon (0.5 s); `None` if nothing could be compared.
    pub light: Option<Light>,
    /// The same verdict for the twin with the residual of the half second before each start.
    pub light_with_residual: Option<Light>,
}

/// Errors at one horizon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Horizon {
    /// Time from the start of each flight, s.
    pub horizon_s: f64,
    /// The axes that are compared.
    pub axes: Vec<AxisReport>,
}

/// Root mean square errors of one coordinate, in `unit`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AxisReport {
    /// Name of the coordinate.
    pub row: &'static str,
    /// Unit of the errors: m or rad.
    pub unit: &'static str,
    /// Error of the twin.
    pub twin_rms: f64,
    /// Error of the twin with the residual that was measured before the start.
    pub with_residual_rms: f64,
    /// Error of coasting.
    pub coasting_rms: f64,
    /// Verdict on the twin.
    pub light: Light,
    /// Verdict on the twin with the residual.
    pub light_with_residual: Light,
}

/// Summarises `shots`. `held` describes the commands if the flights follow the recorded attitude.
pub(super) fn report(twin: &str, held: &'static str, shots: &[TwinFlight]) -> Report {
    let horizons: Vec<Horizon> = HORIZONS
        .iter()
        .enumerate()
        .map(|(i, ticks)| Horizon {
            horizon_s: *ticks as f64 * TICK_S,
            axes: (0..AXES).filter_map(|row| axis(shots, i, row)).collect(),
        })
        .collect();
    let worst = |of: fn(&AxisReport) -> Light| horizons[1].axes.iter().map(of).max();
    Report {
        twin: twin.to_owned(),
        commands: match shots.first() {
            None => "none: no part of the recording has known force and motion for long enough",
            Some(shot) if shot.free => "recorded force and torque",
            Some(_) => held,
        },
        flights: shots.len(),
        light: worst(|axis| axis.light),
        light_with_residual: worst(|axis| axis.light_with_residual),
        horizons,
    }
}

fn axis(shots: &[TwinFlight], horizon: usize, row: usize) -> Option<AxisReport> {
    let rms = |of: fn(&PredictionError) -> Option<f64>| {
        let values: Vec<f64> =
            shots.iter().filter_map(|shot| of(&shot.after[horizon][row])).collect();
        let mean = values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64;
        (!values.is_empty()).then(|| mean.sqrt())
    };
    let (twin_rms, with_residual_rms, coasting_rms) =
        (rms(|m| m.twin)?, rms(|m| m.with_residual)?, rms(|m| m.coasting)?);
    Some(AxisReport {
        row: COORDINATE_NAMES[row],
        unit: if row < 3 { "m" } else { "rad" },
        twin_rms,
        with_residual_rms,
        coasting_rms,
        light: Light::of(twin_rms, coasting_rms),
        light_with_residual: Light::of(with_residual_rms, coasting_rms),
    })
}
