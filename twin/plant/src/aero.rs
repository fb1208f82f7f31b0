//! Aerodynamic forces besides those of the rotors: drag of body, arm and payload, and the unsteady flow around the vehicle.
//!
//! In: pose, velocity, wind. Out: force and moment on the base, forces on arm and payload. State: unsteady force and moment.

use nalgebra::{Matrix3, Vector3};
use rand::distr::Distribution;
use rand_pcg::Pcg64;

use super::inflow::AIR_KG_M3;
use super::settings::AeroSettings;
use super::wind::WindNow;
use twin_core::elementary::exp;
use twin_core::normal::StandardNormal;

/// Pose and velocity of the base, and the wind.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flow {
    /// `world_from_body`.
    pub(super) rotation: Matrix3<f64>,
    /// Origin of the root link in the world, m.
    pub(super) position: Vector3<f64>,
    /// Its velocity in the world, m/s.
    pub(super) velocity: Vector3<f64>,
    /// Angular velocity in the body, rad/s.
    pub(super) omega: Vector3<f64>,
    /// Wind.
    pub(super) wind: WindNow,
}

impl Flow {
    /// Position in the world of a place on the body, m.
    pub(super) fn point(&self, place_in_body: &Vector3<f64>) -> Vector3<f64> {
        self.position + self.rotation * place_in_body
    }

    /// Velocity of a place on the body through the air, and the wind there, both in the body frame, m/s.
    pub(super) fn through_air(&self, place_in_body: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let body_from_world = self.rotation.transpose();
        let wind = body_from_world * self.wind.at(&self.point(place_in_body));
        let velocity = body_from_world * self.velocity + self.omega.cross(place_in_body);
        [velocity - wind, wind]
    }
}

/// Forces on the base, N, and a moment in the body frame, N m.
#[derive(Clone, Copy, Debug)]
pub(super) struct BaseLoads {
    /// Drag of the body as it would be without wind, in the world.
    pub(super) drag: Vector3<f64>,
    /// What the wind adds to it, in the world.
    pub(super) wind: Vector3<f64>,
    /// Force of the unsteady flow, in the world.
    pub(super) unsteady: Vector3<f64>,
    /// Moment of the unsteady flow.
    pub(super) moment: Vector3<f64>,
}

/// The air around the vehicle.
#[derive(Clone, Debug)]
pub(super) struct Aero {
    pub(super) settings: AeroSettings,
    unsteady_force: Vector3<f64>,
    unsteady_moment: Vector3<f64>,
}

impl Aero {
    pub(super) fn new(settings: &AeroSettings) -> Self {
        Self {
            settings: *settings,
            unsteady_force: Vector3::zeros(),
            unsteady_moment: Vector3::zeros(),
        }
    }

    /// Loads on the base without its rotors. Advances the unsteady flow by `dt_s`.
    pub(super) fn step(&mut self, flow: &Flow, dt_s: f64, rng: &mut Pcg64) -> BaseLoads {
        let s = self.settings;
        let decay = exp(-dt_s / s.turbulence_s);
        let spread = (1.0 - decay * decay).sqrt();
        let mut draw = |old: f64, std: f64| {
            let n: f64 = StandardNormal.sample(rng);
            old * decay + std * spread * n
        };
        self.unsteady_force = self.unsteady_force.map(|f| draw(f, s.turbulence_n));
        self.unsteady_moment = self.unsteady_moment.map(|m| draw(m, s.turbulence_n_m));
        let (still, windy) = if s.body_drag {
            let drag = |air: Vector3<f64>| air * (-s.body_drag_n_s2_m2 * air.norm());
            let wind = flow.wind.at(&flow.position);
            (drag(flow.velocity), drag(flow.velocity - wind))
        } else {
            (Vector3::zeros(), Vector3::zeros())
        };
        let unsteady = if s.unsteady { 1.0 } else { 0.0 };
        BaseLoads {
            drag: still,
            wind: windy - still,
            unsteady: self.unsteady_force * unsteady,
            moment: self.unsteady_moment * unsteady,
        }
    }

    /// Forces in the world (N) on a part with drag area `drag_area_m2` that moves with `velocity` (m/s): in still air, and what wind and
    /// wake (m/s) add.
    pub(super) fn part(
        &self,
        drag_area_m2: f64,
        velocity: &Vector3<f64>,
        wind: &Vector3<f64>,
        wake: &Vector3<f64>,
    ) -> PartLoads {
        let force = |air: Vector3<f64>| air * (-0.5 * AIR_KG_M3 * drag_area_m2 * air.norm());
        let own = if self.settings.body_drag { *velocity } else { Vector3::zeros() };
        let wind = if self.settings.body_drag { *wind } else { Vector3::zeros() };
        let (still, windy) = (force(own), force(own - wind));
        let all = force(own - wind - wake);
        PartLoads { drag: still, wind: windy - still, wake: all - windy }
    }
}

/// Forces on a part of the arm or on the payload in the world, N.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PartLoads {
    /// Drag in still air.
    pub(super) drag: Vector3<f64>,
    /// What the wind adds.
    pub(super) wind: Vector3<f64>,
    /// What the wake adds.
    pub(super) wake: Vector3<f64>,
}

impl PartLoads {
    /// All forces together, N.
    pub(super) fn sum(&self) -> Vector3<f64> {
        self.drag + self.wind + self.wake
    }
}
