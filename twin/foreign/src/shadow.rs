//! Flies a recording through the same loop in shadow: the loop predicts and adapts, and commands nothing.
//!
//! Weights that were trained on one vehicle mean nothing on another, so the predictor learns in flight, unless weights are given. The
//! reference is the ghost: the pose at this tick that the twin expected half a second before. The tracking error is then the divergence
//! from it.

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::{Vector2, Vector3};
use serde::Serialize;

use super::forecaster::Forecaster;
use super::gate;
use super::knowledge::{Knowledge, knowledge};
use super::phases::{Phase, Span};
use super::shadow_score::{Score, Scored};
use crate::playback::{Cursor, Playback};
use crate::{OpenedFlight, RecordedFlight, RecordedSource};
use twin_core::control::{Adaptive, Allocation, Gains, InnerController, LoopDelays, Preset, Rotor};
use twin_core::elementary::squared;
use twin_core::filter::LowPass;
use twin_core::flight::{Flight, Parts};
use twin_core::notation::{Coords, GRAVITY_M_S2, KnownCoords, N, TICK_S};
use twin_core::residual::{label, lra};
use twin_core::task::{Step, Task, View};
use twin_core::tick::{Adaptation, Event, EventKind, GripperCommand, Reference, Setpoint, Tick};
use twin_core::tuning::Tuning;
use twin_input::interruption;

/// Smallest standard deviation of a residual that is used as a scale, N and N m.
const LEAST_SCALE: f64 = 1e-9;

/// Age in ticks of the knowledge from which the ghost is computed.
pub const GHOST_TICKS: usize = 50;

/// Corner of the low-pass on the residual, Hz. The ghost assumes that the filtered residual stays constant.
const GHOST_CORNER_HZ: f64 = 0.5;

/// Result of flying a recording in shadow.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShadowReport {
    /// The predictor, and what it knows about this vehicle.
    pub predictor: String,
    /// Number of ticks flown.
    pub ticks: usize,
    /// Duration of these ticks, s.
    pub flight_s: f64,
    /// Number of ticks in which the vehicle flies, judged by its thrust.
    pub airborne_ticks: usize,
    /// Number of ticks without any known residual in the air; the adapter is frozen in them.
    pub held_ticks: usize,
    /// Times of the covariance resets, s from the start of the recording.
    pub resets_s: Vec<f64>,
    /// Number of ticks with a fault.
    pub fault_ticks: usize,
    /// Coordinates, residuals and predictions.
    #[serde(flatten)]
    pub scored: Scored,
    /// Where the forecasts are better than persistence and than the mean, and where they are not, in words.
    pub gate: String,
    /// Hash that is equal for equal flights.
    pub state_hash: String,
}

/// A recorded flight that can be flown in shadow from any of its ticks.
#[derive(Clone, Debug)]
pub struct Shadow {
    playback: Arc<Playback>,
    nominal: Coords,
    scale: Coords,
    tuning: Tuning,
    forecaster: Forecaster,
    /// Where the residual of the whole recording is known; empty if it is read while it is flown.
    knowledge: Vec<Knowledge>,
    /// Phases of the flight, in order of time.
    spans: Arc<[Span]>,
}

impl Shadow {
    /// A shadow of an opened recording. If the recording is read while it is flown, the scale is that of the stretches that were read on
    /// opening.
    pub fn of(opened: &OpenedFlight) -> Self {
        let inertia_kg_m2 = opened.map.vehicle.inertia_kg_m2;
        let whole = Self::new(&opened.recorded, inertia_kg_m2);
        let Some(parts) = &opened.long else { return whole };
        Self { playback: Arc::new(Playback::of(parts)), knowledge: Vec::new(), ..whole }
    }

    /// A shadow of `recorded`; `inertia_kg_m2` is the inertia about the body axes if it is known.
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
        let playback = Arc::new(Playback::whole(recorded));
        let scale = scale(&playback, &gains.nominal_inertia);
        let tuning = Tuning { gains, adapter: lra::Settings::default() };
        let knowledge = knowledge(&playback);
        Self {
            playback,
            nominal,
            scale,
            tuning,
            forecaster: Forecaster::default(),
            knowledge,
            spans: recorded.spans.clone().into(),
        }
    }

    /// The same shadow with another predictor.
    #[must_use]
    pub fn with(self, forecaster: Forecaster) -> Self {
        Self { forecaster, ..self }
    }

    /// What predicts.
    pub fn forecaster(&self) -> &Forecaster {
        &self.forecaster
    }

    /// Where the residual is known, in order of time; empty if it is not known before it is flown.
    pub fn knowledge(&self) -> &[Knowledge] {
        &self.knowledge
    }

    /// Whether the residual is known before tick `first`; `None` at the start, and if it is not known.
    fn known_before(&self, first: usize) -> Option<bool> {
        self.knowledge
            .iter()
            .take_while(|stretch| stretch.first < first)
            .last()
            .map(|last| last.known)
    }

    /// Weight of the vehicle, N; for a vehicle of unknown mass that of one kilogram.
    pub fn weight(&self) -> f64 {
        self.nominal[2]
    }

    /// Number of ticks of the recording.
    pub fn ticks(&self) -> usize {
        self.playback.ticks()
    }

    /// The values in force at the start.
    pub fn tuning(&self) -> &Tuning {
        &self.tuning
    }

    /// Standard deviation of the residual per coordinate, N and N m: the unit of the adapter's innovation.
    pub fn scale(&self) -> &Coords {
        &self.scale
    }

    /// The recording as a playback.
    pub fn playback(&self) -> &Arc<Playback> {
        &self.playback
    }

    /// The flight from tick `first` on; `None` beyond the end.
    pub fn flight(&self, first: usize, tuning: &Tuning) -> Option<Flight> {
        let source = RecordedSource::new(&self.playback, first)?;
        Some(Flight::starting_at(self.parts(source, first, tuning), first as u64))
    }

    fn parts(&self, source: RecordedSource, first: usize, tuning: &Tuning) -> Parts {
        let nominal = self.nominal;
        let predictor = self.forecaster.predictor();
        let history_len = predictor.history_len();
        let adapter = lra::Adapter::new(predictor.regime_len(), self.scale, &tuning.adapter);
        // The shadow commands no rotor, so any rotor geometry will do.
        let rotor = Rotor { position_in_body: Vector3::x(), torque_per_thrust_m: 0.01 };
        let inner = InnerController::new(
            Allocation::new(&[rotor; 4], 0.0, f64::MAX),
            Vector3::repeat(1.0),
            Vector2::zeros(),
            tuning.gains.safe_set.tilt_rad,
            TICK_S,
        );
        Parts {
            source: Box::new(source),
            predictor,
            adapter,
            controller: Box::new(Adaptive::default()),
            inner,
            task: Box::new(Watch::new(self, first)),
            gravity: Arc::new(move |_| nominal),
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
            // A shadow commands nothing, so only its estimate is late.
            delays: LoopDelays::default(),
            history_len,
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
    /// Flies to the end, or until a signal asks the program to end; `None` if there is no tick.
    pub fn fly(&self, watch: &mut dyn FnMut(&Tick)) -> Option<ShadowReport> {
        let mut flight = self.flight(0, &self.tuning)?;
        let mut score = Score::new(self.scale);
        let (mut resets_s, mut fault_ticks) = (Vec::new(), 0);
        let (mut airborne_ticks, mut held_ticks) = (0, 0);
        let mut ticks = 0;
        while ticks < self.ticks() && interruption::requested().is_none() {
            let tick = flight.tick();
            ticks += 1;
            if tick.adapted.reset {
                resets_s.push(tick.measurement.t_s);
            }
            fault_ticks += usize::from(tick.fault.is_some());
            airborne_ticks += usize::from(tick.measurement.airborne);
            held_ticks += usize::from(!tick.residual.is_any_known());
            score.add(&tick);
            watch(&tick);
        }
        Some(ShadowReport {
            predictor: self.forecaster.sentence(),
            ticks,
            flight_s: ticks as f64 * TICK_S,
            airborne_ticks,
            held_ticks,
            resets_s,
            fault_ticks,
            gate: gate::sentence(&score.prediction()),
            scored: score.finish(ticks),
            state_hash: format!("{:016x}", flight.state_hash()),
        })
    }
}

/// Standard deviation of the residual per coordinate over the flight: the unit of the adapter's innovation.
fn scale(playback: &Arc<Playback>, nominal_inertia: &Coords) -> Coords {
    let mut cursor = Cursor::new(playback);
    let mut residuals: [Vec<f64>; N] = Default::default();
    for tick in 0..playback.ticks() {
        let Some(measurement) = cursor.frame(tick) else { continue };
        let residual = label::residual(measurement, nominal_inertia);
        for (row, values) in residuals.iter_mut().enumerate() {
            values.extend(residual.get(row));
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

/// Task that flies nothing: its reference is the expected pose, and it freezes the adapter while no residual is known.
#[derive(Clone)]
struct Watch {
    /// Number of ticks of the flight; `None` while it still goes on.
    ticks: Option<usize>,
    next: usize,
    nominal_residual: Coords,
    nominal_inertia: Coords,
    residual: LowPass<N>,
    held: Option<bool>,
    spans: Arc<[Span]>,
    /// Start states of the ghost at the last ticks, oldest first.
    starts: VecDeque<Start>,
}

/// A start state of the ghost. It is integrated with the measured force and with the residual of its first tick. A coordinate that was
/// unknown at any of these ticks is NaN from then on.
#[derive(Clone)]
struct Start {
    chi: Coords,
    chi_dot: Coords,
    residual: Coords,
}

impl Watch {
    fn new(shadow: &Shadow, first: usize) -> Self {
        let playback = &shadow.playback;
        Self {
            ticks: (!playback.is_live()).then(|| playback.ticks()),
            next: first,
            nominal_residual: shadow.nominal,
            nominal_inertia: shadow.tuning.gains.nominal_inertia,
            residual: LowPass::new(),
            held: shadow.known_before(first).map(|known| !known),
            spans: Arc::clone(&shadow.spans),
            starts: VecDeque::new(),
        }
    }

    /// Phase of a tick at `t_s` without a known residual: where the vehicle is instead of in the air.
    fn held_phase(&self, t_s: f64) -> &'static str {
        let after = self.spans.partition_point(|span| span.from_s <= t_s);
        let span = after.checked_sub(1).and_then(|at| self.spans.get(at));
        let elsewhere =
            |span: &&Span| t_s < span.to_s && !matches!(span.phase, Phase::Air | Phase::Unknown);
        span.filter(elsewhere).map_or("unknown", |span| span.phase.words())
    }

    /// Pose and rates at which the vehicle was expected now. A coordinate without a known force gets its measured value.
    fn ghost(&mut self, view: &View<'_>) -> (KnownCoords, KnownCoords) {
        let measured = view.measurement;
        if !view.residual.is_any_known() {
            self.starts.clear();
            return (measured.chi, measured.chi_dot);
        }
        for start in &mut self.starts {
            for row in 0..N {
                let force = measured.tau_applied[row] - start.residual[row];
                start.chi_dot[row] += force / self.nominal_inertia[row] * TICK_S;
                start.chi[row] += start.chi_dot[row] * TICK_S;
            }
        }
        // The low-pass needs a number in every coordinate; the nominal residual stands for an unknown one.
        let residual = view.residual.or(&self.nominal_residual);
        let residual = self.residual.step(&residual, GHOST_CORNER_HZ, TICK_S);
        let expected = if self.starts.len() < GHOST_TICKS { None } else { self.starts.pop_front() };
        let start = Start { chi: *measured.chi, chi_dot: *measured.chi_dot, residual };
        self.starts.push_back(start);
        let Some(expected) = expected else { return (measured.chi, measured.chi_dot) };
        let either = |expected: &Coords, measured: &KnownCoords| {
            let expects =
                |row: usize| expected[row].is_finite() && view.residual.get(row).is_some();
            KnownCoords::from_rows(&std::array::from_fn(|row| {
                if expects(row) { Some(expected[row]) } else { measured.get(row) }
            }))
        };
        (either(&expected.chi, &measured.chi), either(&expected.chi_dot, &measured.chi_dot))
    }
}

impl Task for Watch {
    fn update(&mut self, view: &View<'_>, _dt_s: f64) -> Step {
        let held = !view.residual.is_any_known();
        self.next += 1;
        let stretch = Knowledge { first: self.next - 1, known: !held };
        let news = (self.held != Some(held)).then(|| Event::new(EventKind::Phase, stretch.text()));
        self.held = Some(held);
        let (chi_des, chi_des_dot) = self.ghost(view);
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
            phase: if held { self.held_phase(view.measurement.t_s) } else { "mirrored" },
            events: news.into_iter().collect(),
            finished: self.ticks.is_some_and(|ticks| self.next >= ticks),
            gave_up: None,
        }
    }
}
