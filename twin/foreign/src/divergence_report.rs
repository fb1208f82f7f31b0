//! What the flights of the twin beside a recording say: how far off it is per axis and horizon, and whether it holds.

use serde::Serialize;
use ts_rs::TS;

use twin_core::notation::{ROWS, TICK_S};

/// Ticks after which twin and flight are compared: 0.1, 0.5, 1 s.
pub const HORIZONS: [usize; 3] = [10, 50, 100];

/// Rows that are compared: those of the base.
pub const AXES: usize = 6;

/// One number per axis of the base, m and rad.
pub(super) type Axis = [f64; AXES];

/// Motion capture, and the slope of its poses over 80 ms, are not better than this over a second, m or rad.
const FLOOR: f64 = 0.02;

/// A twin that says the motion at least so much better than coasting is good for something.
const GOOD_SHARE: f64 = 0.5;

/// One flight of the twin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shot {
    /// When it starts, s of the recording.
    pub t_s: f64,
    /// The torque is known, so its attitude is its own.
    pub free: bool,
    /// Per horizon and axis.
    pub after: [[Miss; AXES]; HORIZONS.len()],
}

/// How far from the flight, m or rad; `None` where it is not compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Miss {
    /// The twin.
    pub twin: Option<f64>,
    /// The twin with the residual of before the start.
    pub with_residual: Option<f64>,
    /// What simply went on as it moved at the start.
    pub coasting: Option<f64>,
}

/// Whether the twin says where the vehicle goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum Light {
    /// Its error is below half of that of coasting, or below what is measured.
    Valid,
    /// Better than coasting, or within twice of what is measured.
    Doubtful,
    /// Going on as before says it better.
    Invalid,
}

impl Light {
    /// Of an error beside that of coasting, m or rad.
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

    /// The worst of what is compared of a flight of the twin.
    pub fn worst(misses: &[Miss; AXES]) -> Option<Self> {
        misses.iter().filter_map(|m| Some(Self::of(m.twin?, m.coasting?))).max()
    }
}

/// All flights of the twin along a recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// What flew.
    pub twin: String,
    /// Under which commands.
    pub commands: &'static str,
    /// Flights.
    pub flights: usize,
    /// Per horizon.
    pub horizons: Vec<Horizon>,
    /// The worst axis at the second horizon (0.5 s); absent if nothing could be compared.
    pub light: Option<Light>,
    /// The same of the twin with the residual of the half second before each start.
    pub light_with_residual: Option<Light>,
}

/// One horizon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Horizon {
    /// Time from the start of each flight, s.
    pub horizon_s: f64,
    /// Axes that are compared.
    pub axes: Vec<AxisReport>,
}

/// Root mean square errors of one axis, in `unit`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AxisReport {
    /// Name of the row.
    pub row: &'static str,
    /// m or rad.
    pub unit: &'static str,
    /// Of the twin.
    pub twin_rms: f64,
    /// Of the twin with the residual of before the start.
    pub with_residual_rms: f64,
    /// Of what simply went on as it moved.
    pub coasting_rms: f64,
    /// Of the twin.
    pub light: Light,
    /// Of the twin with the residual.
    pub light_with_residual: Light,
}

/// The report of these flights, `held` if they have the attitude of the recording.
pub(super) fn report(twin: &str, held: &'static str, shots: &[Shot]) -> Report {
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
            None => "none: force and motion are nowhere known for long enough",
            Some(shot) if shot.free => "recorded force and torque",
            Some(_) => held,
        },
        flights: shots.len(),
        light: worst(|axis| axis.light),
        light_with_residual: worst(|axis| axis.light_with_residual),
        horizons,
    }
}

fn axis(shots: &[Shot], horizon: usize, row: usize) -> Option<AxisReport> {
    let rms = |of: fn(&Miss) -> Option<f64>| {
        let values: Vec<f64> =
            shots.iter().filter_map(|shot| of(&shot.after[horizon][row])).collect();
        let mean = values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64;
        (!values.is_empty()).then(|| mean.sqrt())
    };
    let (twin_rms, with_residual_rms, coasting_rms) =
        (rms(|m| m.twin)?, rms(|m| m.with_residual)?, rms(|m| m.coasting)?);
    Some(AxisReport {
        row: ROWS[row],
        unit: if row < 3 { "m" } else { "rad" },
        twin_rms,
        with_residual_rms,
        coasting_rms,
        light: Light::of(twin_rms, coasting_rms),
        light_with_residual: Light::of(with_residual_rms, coasting_rms),
    })
}
