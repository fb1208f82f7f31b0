//! A recorded flight through the same loop in shadow: predicting and adapting, never acting.
//!
//! Weights that were trained on one vehicle mean nothing on another, so the predictor is `random_features`. The reference is
//! where the twin expected the vehicle at this tick, from what it knew half a second before: the ghost, and the divergence.

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::{Vector2, Vector3};
use serde::Serialize;

use super::shadow_score::{Score, Scored};
use crate::film::{Cursor, Film, Nominal};
use crate::{OpenedFlight, RecordedFlight, RecordedSource};
use twin_core::control::{Adaptive, Allocation, Gains, Preset, Rotor, Rows};
use twin_core::elementary::squared;
use twin_core::filter::LowPass;
use twin_core::flight::{Flight, Parts};
use twin_core::notation::{Coords, GRAVITY_M_S2, N, ROWS, TICK_S};
use twin_core::residual::{Predictor, RandomFeatures, lra};
use twin_core::task::{Step, Task, View};
use twin_core::tick::{Adaptation, Event, EventKind, GripperCommand, Reference, Setpoint, Tick};
use twin_core::tuning::Tuning;

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
    film: Arc<Film>,
    nominal: Coords,
    scale: Coords,
    tuning: Tuning,
}

impl Shadow {
    /// Of an opened recording: whole, or read as it is flown; then its scale is that of the stretches that were read.
    pub fn of(opened: &OpenedFlight) -> Self {
        let inertia_kg_m2 = opened.map.vehicle.inertia_kg_m2;
        let whole = Self::new(&opened.recorded, inertia_kg_m2);
        let Some(footage) = &opened.long else { return whole };
        let inertia = whole.tuning.gains.nominal_inertia;
        let film = Film::of(footage, Nominal { residual: whole.nominal, inertia });
        Self { film: Arc::new(film), ..whole }
    }

    /// `inertia_kg_m2` about the body axes where it is known.
    pub fn new(recorded: &RecordedFlight, inertia_kg_m2: Option<[f64; 3]>) -> Self {
        let mut gains = Gains::preset(Preset::Paper);
        let inertia_kg_m2 = inertia_kg_m2.or(recorded.fitted_inertia());
        for row in 0..3 {
            gains.nominal_inertia[row] = recorded.mass_kg;
            if let Some(inertia) = inertia_kg_m2 {
                gains.nominal_inertia[3 + row] = inertia[row];
            }
        }
        gains.nominal_inertia = recorded.nominal_inertia.unwrap_or(gains.nominal_inertia);
        let mut nominal = Coords::zeros();
        nominal[2] = recorded.mass_kg * GRAVITY_M_S2;
        let inertia = gains.nominal_inertia;
        let film = Arc::new(Film::whole(recorded, &Nominal { residual: nominal, inertia }));
        let scale = scale(&film, &inertia);
        let tuning = Tuning { gains, adapter: lra::Settings::default() };
        Self { film, nominal, scale, tuning }
    }

    /// Ticks of the recording.
    pub fn ticks(&self) -> usize {
        self.film.ticks()
    }

    /// The values in force at the start.
    pub fn tuning(&self) -> &Tuning {
        &self.tuning
    }

    /// Standard deviation of the residual per row: the unit of the adapter's innovation, N and N m.
    pub fn scale(&self) -> &Coords {
        &self.scale
    }

    /// The recording, tick by tick.
    pub fn film(&self) -> &Arc<Film> {
        &self.film
    }

    /// The flight from tick `first` on; `None` beyond the end.
    pub fn flight(&self, first: usize, tuning: &Tuning) -> Option<Flight> {
        let source = RecordedSource::new(&self.film, first)?;
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
            tuning.gains.safe_set.tilt_rad,
            TICK_S,
        );
        Parts {
            source: Box::new(source),
            predictor: Box::new(predictor),
            adapter,
            controller: Box::new(Adaptive::default()),
            rows,
            task: Box::new(Watch::new(&self.film, first, self.tuning.gains.nominal_inertia)),
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
    Shadow::new(recorded, inertia_kg_m2).fly(watch)
}

impl Shadow {
    /// Flies to the end; `None` if there is no tick.
    pub fn fly(&self, watch: &mut dyn FnMut(&Tick)) -> Option<ShadowReport> {
        let mut flight = self.flight(0, &self.tuning)?;
        let mut cursor = Cursor::new(&self.film);
        let mut score = Score::new(self.scale);
        let (mut resets_s, mut fault_ticks) = (Vec::new(), 0);
        let (mut airborne_ticks, mut held_ticks) = (0, 0);
        for index in 0..self.ticks() {
            let tick = flight.tick();
            if tick.adapted.reset {
                resets_s.push(tick.measurement.t_s);
            }
            fault_ticks += usize::from(tick.fault.is_some());
            if let Some(frame) = cursor.frame(index) {
                airborne_ticks += usize::from(frame.airborne);
                held_ticks += usize::from(!frame.counts.contains(&true));
                score.add(&tick, frame.coordinates, frame.counts);
            }
            watch(&tick);
        }
        Some(ShadowReport {
            predictor: PREDICTOR,
            ticks: self.ticks(),
            flight_s: self.ticks() as f64 * TICK_S,
            airborne_ticks,
            held_ticks,
            resets_s,
            fault_ticks,
            scored: score.finish(self.ticks()),
            state_hash: format!("{:016x}", flight.state_hash()),
        })
    }
}

/// Standard deviation of the residual per row over the flight: the unit of the adapter's innovation.
fn scale(film: &Arc<Film>, nominal_inertia: &Coords) -> Coords {
    let mut cursor = Cursor::new(film);
    let mut residuals: [Vec<f64>; N] = Default::default();
    for tick in 0..film.ticks() {
        let Some(frame) = cursor.frame(tick) else { continue };
        let m = &frame.measurement;
        for row in (0..N).filter(|row| frame.counts[*row]) {
            residuals[row].push(m.tau_applied[row] - nominal_inertia[row] * m.chi_ddot[row]);
        }
    }
    Coords::from_fn(|row, _| {
        let values = &residuals[row];
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        let std = (values.iter().map(|v| squared(v - mean)).sum::<f64>() / n).sqrt();
        if values.is_empty() { 1.0 } else { std.max(LEAST_SCALE) }
    })
}

/// Flies nothing: the reference is where the vehicle was expected, and adaptation is held where nothing is known.
struct Watch {
    cursor: Cursor,
    /// Ticks of the flight; none of one that still goes on.
    ticks: Option<usize>,
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
    fn new(film: &Arc<Film>, first: usize, nominal_inertia: Coords) -> Self {
        Self {
            cursor: Cursor::new(film),
            ticks: (!film.is_live()).then(|| film.ticks()),
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
        let counts = self.cursor.frame(self.next).map_or([false; N], |frame| frame.counts);
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
            finished: self.ticks.is_some_and(|ticks| self.next >= ticks),
            gave_up: None,
        }
    }
}

/// `tick` with everything that is not known there as NaN, which a recording keeps as `null`; `known` is per row of the coordinates
/// and of the residual.
pub fn masked(tick: &Tick, (coordinates, residuals): ([bool; N], [bool; N])) -> Tick {
    let mut tick = tick.clone();
    let hide = |values: &mut Coords, known: &[bool; N]| {
        (0..N).filter(|row| !known[*row]).for_each(|row| values[row] = f64::NAN);
    };
    let Tick { measurement, reference, control, adapted, forecast, setpoint, residual, .. } =
        &mut tick;
    let moved = [&mut measurement.chi, &mut measurement.chi_dot, &mut reference.chi_des];
    let compared = [&mut reference.chi_des_dot, &mut control.error];
    moved.into_iter().chain(compared).for_each(|values| hide(values, &coordinates));
    let forces = [&mut measurement.chi_ddot, &mut measurement.tau_applied, residual];
    let learned = [&mut adapted.r_hat, &mut adapted.r_hat_prior, &mut adapted.innovation];
    let all = forces.into_iter().chain(learned).chain([&mut setpoint.r_hat]);
    all.chain(&mut forecast.base).for_each(|values| hide(values, &residuals));
    tick
}

/// Unit of a row's residual.
pub(super) fn unit(row: usize) -> &'static str {
    if matches!(ROWS[row], "x" | "y" | "z") { "N" } else { "N m" }
}
