//! Aerodynamics: rotor drag, body drag, ground effect, downwash with its slow wake, unsteady flow. Each can be switched off.
//!
//! In: pose, velocity, thrusts, wind. Out: thrusts after ground effect, force and moment on the base, wake velocity at points.
//! State: wake of each rotor, unsteady force and moment.

use nalgebra::{Matrix3, Vector3};
use rand::distr::Distribution;
use rand_pcg::Pcg64;

use super::arena::Arena;
use super::rotors::Rotors;
use super::settings::AeroSettings;
use twin_core::elementary::{exp, squared};
use twin_core::normal::StandardNormal;
use twin_core::notation::{MAX_ROTORS, PerRotor};

/// Air density at 15 °C and sea level, kg/m³.
const AIR_KG_M3: f64 = 1.225;

/// Collective thrust for which the coefficient of rotor drag is given, N.
const DRAG_REFERENCE_N: f64 = 30.0;

/// Far wake, the jet below a hovering rotor: its radius per rotor radius, and the growth of its radius per metre of depth.
const WAKE_CONTRACTION: f64 = 0.78;
const WAKE_SPREAD: f64 = 0.1;

/// Pose and velocity of the base, and the wind.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flow {
    /// `world_from_body`.
    pub(super) rotation: Matrix3<f64>,
    /// Origin of the root link in the world, m.
    pub(super) position: Vector3<f64>,
    /// Its velocity in the world, m/s.
    pub(super) velocity: Vector3<f64>,
    /// Wind in the world, m/s.
    pub(super) wind: Vector3<f64>,
}

/// The air around the vehicle.
#[derive(Clone, Debug)]
pub(super) struct Aero {
    pub(super) settings: AeroSettings,
    /// Wind has an effect.
    pub(super) wind_on: bool,
    wake_m_s: PerRotor,
    unsteady_force: Vector3<f64>,
    unsteady_moment: Vector3<f64>,
}

impl Aero {
    pub(super) fn new(settings: &AeroSettings) -> Self {
        Self {
            settings: *settings,
            wind_on: true,
            wake_m_s: [0.0; MAX_ROTORS],
            unsteady_force: Vector3::zeros(),
            unsteady_moment: Vector3::zeros(),
        }
    }

    /// Switches an effect; false if there is none of that name.
    pub(super) fn switch(&mut self, name: &str, on: bool) -> bool {
        match name {
            "rotor_drag" => self.settings.rotor_drag = on,
            "body_drag" => self.settings.body_drag = on,
            "ground_effect" => self.settings.ground_effect = on,
            "downwash" => self.settings.downwash = on,
            "wind" => self.wind_on = on,
            _ => return false,
        }
        true
    }

    /// Thrust of each rotor near surfaces, N: `T / (1 - (R / 4h)^2)` (Cheeseman and Bennett 1955), with the height h above the
    /// nearest surface below the rotor.
    pub(super) fn thrust_near_surfaces(
        &self,
        rotors: &Rotors,
        flow: &Flow,
        arena: &Arena,
    ) -> PerRotor {
        let mut thrust_n = rotors.thrust_n;
        let radius = self.settings.ground_effect_radius_m;
        // A rotor without a radius has no ground effect, also below the ground, where the ratio of radius and height is unknown.
        if self.settings.ground_effect && radius > 0.0 {
            for (place, n) in rotors.places.iter().zip(&mut thrust_n) {
                let hub = flow.position + flow.rotation * Vector3::from(place.position_m);
                let height = (hub.z - arena.height_below(&hub)).max(0.5 * radius);
                *n /= 1.0 - squared(radius / (4.0 * height));
            }
        }
        thrust_n
    }

    /// Aerodynamic force in the world (N) and moment in the body (N m) on the base, without thrust. Advances the wake and the
    /// unsteady flow by `dt_s`.
    pub(super) fn step(
        &mut self,
        flow: &Flow,
        rotors: &Rotors,
        thrust_n: &PerRotor,
        dt_s: f64,
        rng: &mut Pcg64,
    ) -> (Vector3<f64>, Vector3<f64>) {
        self.step_wake(rotors, thrust_n, dt_s);
        let s = self.settings;
        let decay = exp(-dt_s / s.turbulence_s);
        let spread = (1.0 - decay * decay).sqrt();
        let mut draw = |old: f64, std: f64| {
            let n: f64 = StandardNormal.sample(rng);
            old * decay + std * spread * n
        };
        self.unsteady_force = self.unsteady_force.map(|f| draw(f, s.turbulence_n));
        self.unsteady_moment = self.unsteady_moment.map(|m| draw(m, s.turbulence_n_m));
        let air_in_world = flow.velocity - if self.wind_on { flow.wind } else { Vector3::zeros() };
        let air = flow.rotation.transpose() * air_in_world;
        let collective: f64 = thrust_n.iter().sum();
        let mut force = Vector3::zeros();
        if s.rotor_drag {
            force -= Vector3::from(s.rotor_drag_n_s_m).component_mul(&air)
                * (collective / DRAG_REFERENCE_N);
        }
        if s.body_drag {
            force -= air * (s.body_drag_n_s2_m2 * air.norm());
        }
        (flow.rotation * force + self.unsteady_force, self.unsteady_moment)
    }

    /// The induced velocity `sqrt(T / 2 rho A)` (momentum theory) reaches the wake with a first-order lag.
    fn step_wake(&mut self, rotors: &Rotors, thrust_n: &PerRotor, dt_s: f64) {
        let area = std::f64::consts::PI * squared(rotors.settings.radius_m);
        let blend = 1.0 - exp(-dt_s / self.settings.wake_s);
        for (wake, n) in self.wake_m_s.iter_mut().zip(thrust_n) {
            *wake += ((n.max(0.0) / (2.0 * AIR_KG_M3 * area)).sqrt() - *wake) * blend;
        }
    }

    /// Wake velocity in the world at a point of the world, m/s; zero above the rotors.
    pub(super) fn wake_at(
        &self,
        point: &Vector3<f64>,
        flow: &Flow,
        rotors: &Rotors,
    ) -> Vector3<f64> {
        if !self.settings.downwash {
            return Vector3::zeros();
        }
        let in_body = flow.rotation.transpose() * (point - flow.position);
        let speed: f64 = rotors
            .places
            .iter()
            .zip(&self.wake_m_s)
            .map(|(place, induced)| {
                let hub = Vector3::from(place.position_m);
                let depth = hub.z - in_body.z;
                if depth <= 0.0 {
                    return 0.0;
                }
                let radius = WAKE_CONTRACTION * rotors.settings.radius_m + WAKE_SPREAD * depth;
                let offset = (in_body - hub).xy().norm_squared();
                2.0 * induced * exp(-offset / (radius * radius))
            })
            .sum();
        flow.rotation * Vector3::new(0.0, 0.0, -speed)
    }
}

/// Drag force in the world on a body with drag area `drag_area_m2` in the wake, N.
pub(super) fn wake_force(wake: &Vector3<f64>, drag_area_m2: f64) -> Vector3<f64> {
    wake * (0.5 * AIR_KG_M3 * drag_area_m2 * wake.norm())
}
