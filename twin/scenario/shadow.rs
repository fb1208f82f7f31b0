//! A recorded flight through the same loop in shadow: predicting and adapting, never acting.
//!
//! Weights that were trained on one vehicle mean nothing on another, so the predictor is `random_features`. The reference is
//! where the twin expected the vehicle at this tick, from what it knew half a second before: the ghost, and the divergence.

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::{Vector2, Vector3};
use serde::Serialize;

use super::shadow_score::{Score, Scored};
use crate::control::{Adaptive, Allocation, Gains, Preset, Rotor, Rows};
use crate::filter::LowPass;
use crate::flight::{Flight, Parts};
use crate::mirror::{RecordedFlight, RecordedSource};
use crate::notation::{Coords, GRAVITY_M_S2, N, ROWS, TICK_S};
use crate::residual::{Predictor, RandomFeatures, lra};
use crate::task::{Step, Task, View};
use crate::tick::{
    Adaptation, Event, EventKind, GripperCommand, Measurement, Reference, Setpoint, Tick,
};
use crate::tuning::Tuning;

/// What predicts, for people.
pub const PREDICTOR: &str =
    "random_features, adapted in flight; not trained on this or any vehicle";

/// Regime features of the adapter and the seed they are drawn from.
const FEATURES: usize = 32;
const SEED: u64 = 1;

/// Ticks of history kept for the predictor.
const HISTORY_LEN: usize = 120;

/// Smallest spread of a residual that is used as a scale, N and N m.
const LEAST_SCALE: f64 = 1e-9;

/// The ghost is where the vehicle was expected from what was known so many ticks ago.
pub const GHOST_TICKS: usize = 50;

/// What an operator reads when a residual begins and ends to be known.
const MIRRORED: &str = "in the air: residual known, the twin predicts and adapts in shadow";
const UNKNOWN: &str = "on the ground, or force or motion unknown: the twin holds";

/// Corner of the low-pass on the residual that the ghost assumes to stay as it is, Hz.
const GHOST_CORNER_HZ: f64 = 0.5;

/// What the loop made of a flight.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShadowReport {
    /// The predictor, and what it knows about this vehicle.
    pub predictor: &'static str,
    /// Ticks flown.
    pub ticks: usize,
    /// Their time, s.
    pub flight_s: f64,
    /// Ticks in which the vehicle flies, as far as its thrust tells.
    pub airborne_ticks: usize,
    /// Ticks without any known residual in the air: adaptation is held there.
    pub held_ticks: usize,
    /// Covariance resets and when, s from the start of the recording.
    pub resets_s: Vec<f64>,
    /// Ticks with a fault.
    pub fault_ticks: usize,
    /// Rows, residuals and predictions.
    #[serde(flatten)]
    pub scored: Scored,
    /// Equal for equal flights.
    pub state_hash: String,
}

/// A recorded flight that can be flown in shadow from any of its ticks.
#[derive(Clone, Debug)]
pub struct Shadow {
    measurements: Arc<[Measurement]>,
    /// Per tick and row: the residual is known, in the air.
    counts: Arc<[[bool; N]]>,
    nominal: Coords,
    scale: Coords,
    tuning: Tuning,
}

impl Shadow {
    /// `inertia_kg_m2` about the body axes where it is known.
    pub fn new(recorded: &RecordedFlight, inertia_kg_m2: Option<[f64; 3]>) -> Self {
        let mut gains = Gains::preset(Preset::Paper);
        for row in 0..3 {
            gains.nominal_inertia[row] = recorded.mass_kg;
            if let Some(inertia) = inertia_kg_m2 {
                gains.nominal_inertia[3 + row] = inertia[row];
            }
        }
        gains.nominal_inertia = recorded.nominal_inertia.unwrap_or(gains.nominal_inertia);
        let mut nominal = Coords::zeros();
        nominal[2] = recorded.mass_kg * GRAVITY_M_S2;
        let counts: Vec<[bool; N]> = (0..recorded.instants.len())
            .map(|tick| std::array::from_fn(|row| recorded.residual_counts(tick, row)))
            .collect();
        let measurements = recorded.measurements(&nominal, &gains.nominal_inertia);
        let scale = scale(&measurements, &counts, &gains.nominal_inertia);
        let tuning = Tuning { gains, adapter: lra::Settings::default() };
        Self { measurements: measurements.into(), counts: counts.into(), nominal, scale, tuning }
    }

    /// Ticks of the recording.
    pub fn ticks(&self) -> usize {
        self.measurements.len()
    }

    /// The values in force at the start.
    pub fn tuning(&self) -> &Tuning {
        &self.tuning
    }

    /// Standard deviation of the residual per row: the unit of the adapter's innovation, N and N m.
    pub fn scale(&self) -> &Coords {
        &self.scale
    }

    /// Whether the residual of each row is known in the air at `tick`.
    pub fn counts(&self, tick: usize) -> [bool; N] {
        self.counts.get(tick).copied().unwrap_or([false; N])
    }

    /// The flight from tick `first` on; `None` beyond the end.
    pub fn flight(&self, first: usize, tuning: &Tuning) -> Option<Flight> {
        let source = RecordedSource::new(Arc::clone(&self.measurements), first)?;
        Some(Flight::starting_at(self.parts(source, first, tuning), first as u64))
    }

    fn parts(&self, source: RecordedSource, first: usize, tuning: &Tuning) -> Parts {
        let nominal = self.nominal;
        let predictor = RandomFeatures::new(Box::new(move |_| nominal), FEATURES, SEED);
        let adapter = lra::Adapter::new(predictor.regime_len(), self.scale, &tuning.adapter);
        // Nothing is commanded, so any rotor will do.
        let rotor = Rotor { position_in_body: Vector3::x(), torque_per_thrust_m: 0.01 };
        let rows = Rows::new(
            Allocation::new(&[rotor; 4], 0.0, f64::MAX),
            Vector3::repeat(1.0),
            Vector2::zeros(),
            TICK_S,
        );
        Parts {
            source: Box::new(source),
            predictor: Box::new(predictor),
            adapter,
            controller: Box::new(Adaptive::default()),
            rows,
            task: Box::new(Watch::new(
                Arc::clone(&self.counts),
                first,
                self.tuning.gains.nominal_inertia,
            )),
            gravity: Box::new(move |_| nominal),
            setpoint: Setpoint {
                force_in_world_n: Vector3::new(0.0, 0.0, nominal[2]),
                yaw_des: [0.0; 3],
                joint_des: Vector2::zeros(),
                joint_des_dot: Vector2::zeros(),
                joint_des_ddot: Vector2::zeros(),
                r_hat: Coords::zeros(),
                sliding_norm: 1.0,
                robust_gain: 0.0,
                rows: tuning.gains.rows(),
                gripper: GripperCommand::Open,
            },
            tuning: *tuning,
            schedule: Vec::new(),
            triggers: Vec::new(),
            history_len: HISTORY_LEN,
            outer_divisor: 1,
        }
    }
}

/// Flies `recorded` to its end; `None` if it has no tick.
pub fn shadow(
    recorded: &RecordedFlight,
    inertia_kg_m2: Option<[f64; 3]>,
    watch: &mut dyn FnMut(&Tick),
) -> Option<ShadowReport> {
    let shadow = Shadow::new(recorded, inertia_kg_m2);
    let mut flight = shadow.flight(0, &shadow.tuning)?;
    let mut score = Score::new(shadow.scale);
    let (mut resets_s, mut fault_ticks) = (Vec::new(), 0);
    for known in shadow.counts.iter() {
        let tick = flight.tick();
        if tick.adapted.reset {
            resets_s.push(tick.measurement.t_s);
        }
        fault_ticks += usize::from(tick.fault.is_some());
        score.add(&tick, *known);
        watch(&tick);
    }
    Some(ShadowReport {
        predictor: PREDICTOR,
        ticks: shadow.ticks(),
        flight_s: shadow.ticks() as f64 * TICK_S,
        airborne_ticks: recorded.airborne.iter().filter(|flies| **flies).count(),
        held_ticks: shadow.counts.iter().filter(|rows| !rows.contains(&true)).count(),
        resets_s,
        fault_ticks,
        scored: score.finish(recorded),
        state_hash: format!("{:016x}", flight.state_hash()),
    })
}

/// Standard deviation of the residual per row over the flight: the unit of the adapter's innovation.
fn scale(
    measurements: &[crate::tick::Measurement],
    known: &[[bool; N]],
    nominal_inertia: &Coords,
) -> Coords {
    Coords::from_fn(|row, _| {
        let values: Vec<f64> = measurements
            .iter()
            .zip(known)
            .filter(|(_, known)| known[row])
            .map(|(m, _)| m.tau_applied[row] - nominal_inertia[row] * m.chi_ddot[row])
            .collect();
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        let std = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        if values.is_empty() { 1.0 } else { std.max(LEAST_SCALE) }
    })
}

/// Flies nothing: the reference is where the vehicle was expected, and adaptation is held where nothing is known.
struct Watch {
    counts: Arc<[[bool; N]]>,
    next: usize,
    nominal_inertia: Coords,
    residual: LowPass<N>,
    held: Option<bool>,
    /// What was known at each of the last ticks, oldest first.
    known: VecDeque<Known>,
}

/// What the ghost starts from, and the motion that the force since then explains with the residual of then.
struct Known {
    chi: Coords,
    chi_dot: Coords,
    residual: Coords,
}

impl Watch {
    fn new(counts: Arc<[[bool; N]]>, first: usize, nominal_inertia: Coords) -> Self {
        Self {
            counts,
            next: first,
            nominal_inertia,
            residual: LowPass::new(),
            held: None,
            known: VecDeque::new(),
        }
    }

    /// Where the vehicle was expected now. Rows without a known force go where they are.
    fn ghost(&mut self, view: &View<'_>, counts: [bool; N]) -> (Coords, Coords) {
        let measured = view.measurement;
        if !counts.contains(&true) {
            self.known.clear();
            return (measured.chi, measured.chi_dot);
        }
        for known in &mut self.known {
            for row in 0..N {
                let force = measured.tau_applied[row] - known.residual[row];
                known.chi_dot[row] += force / self.nominal_inertia[row] * TICK_S;
                known.chi[row] += known.chi_dot[row] * TICK_S;
            }
        }
        let residual = self.residual.step(view.residual, GHOST_CORNER_HZ, TICK_S);
        let expected = if self.known.len() < GHOST_TICKS { None } else { self.known.pop_front() };
        self.known.push_back(Known { chi: measured.chi, chi_dot: measured.chi_dot, residual });
        let Some(expected) = expected else { return (measured.chi, measured.chi_dot) };
        let either = |expected: &Coords, measured: &Coords| {
            Coords::from_fn(|row, _| if counts[row] { expected[row] } else { measured[row] })
        };
        (either(&expected.chi, &measured.chi), either(&expected.chi_dot, &measured.chi_dot))
    }
}

impl Task for Watch {
    fn update(&mut self, view: &View<'_>, _dt_s: f64) -> Step {
        let counts = self.counts.get(self.next).copied().unwrap_or([false; N]);
        let held = !counts.contains(&true);
        self.next += 1;
        let text = if held { UNKNOWN } else { MIRRORED };
        let news = (self.held != Some(held)).then(|| Event::new(EventKind::Phase, text));
        self.held = Some(held);
        let (chi_des, chi_des_dot) = self.ghost(view, counts);
        Step {
            reference: Reference {
                chi_des,
                chi_des_dot,
                chi_des_ddot: Coords::zeros(),
                gripper: GripperCommand::Open,
                adaptation: if held { Adaptation::Held } else { Adaptation::Free },
                follows_measurement: true,
                transporting: false,
                cruising: false,
                release: None,
            },
            phase: if held { "unknown" } else { "mirrored" },
            events: news.into_iter().collect(),
            finished: self.next >= self.counts.len(),
            gave_up: None,
        }
    }
}

/// Unit of a row's residual.
pub(super) fn unit(row: usize) -> &'static str {
    if matches!(ROWS[row], "x" | "y" | "z") { "N" } else { "N m" }
}
