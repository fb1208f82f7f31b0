//! Propulsion: battery, rotors, the air that flows through them and the wakes that they leave.
//!
//! In: commanded thrusts, motion through the air, surfaces below. Out: force and moment of all rotors in the body frame.

use nalgebra::Vector3;

use super::aero::Flow;
use super::arena::Arena;
use super::battery::Battery;
use super::ground::Ground;
use super::inflow::Inflow;
use super::mismatch::Mismatch;
use super::rotors::Rotors;
use super::settings::{AeroSettings, VehicleSettings};
use super::wake::Wake;
use twin_core::notation::{MAX_ROTORS, PerRotor};

/// Collective thrust for which the coefficient of rotor drag is given, N.
const DRAG_REFERENCE_N: f64 = 30.0;

/// Force and moment of all rotors about the origin of the root link in the body frame, N and N m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RotorWrench {
    /// Thrust that the rotors would give in still air far from everything.
    pub(super) thrust_n: f64,
    /// What the air that flows through the rotors adds to it.
    pub(super) inflow_n: f64,
    /// What the ground adds to it.
    pub(super) ground_n: f64,
    /// Force in the plane of the rotors without wind.
    pub(super) drag: Vector3<f64>,
    /// What the wind adds to it.
    pub(super) wind: Vector3<f64>,
    /// Moment.
    pub(super) moment: Vector3<f64>,
}

impl RotorWrench {
    /// Thrust of all rotors along the body's z axis, N.
    pub(super) fn collective_n(&self) -> f64 {
        self.thrust_n + self.inflow_n + self.ground_n
    }

    /// Force in the body frame, N.
    pub(super) fn force(&self) -> Vector3<f64> {
        Vector3::new(0.0, 0.0, self.collective_n()) + self.drag + self.wind
    }

    /// `share` of `before` and the rest of `self`.
    pub(super) fn after(&self, before: &Self, share: f64) -> Self {
        let rest = 1.0 - share;
        Self {
            thrust_n: before.thrust_n * share + self.thrust_n * rest,
            inflow_n: before.inflow_n * share + self.inflow_n * rest,
            ground_n: before.ground_n * share + self.ground_n * rest,
            drag: before.drag * share + self.drag * rest,
            wind: before.wind * share + self.wind * rest,
            moment: before.moment * share + self.moment * rest,
        }
    }
}

/// Battery, rotors, inflow, ground and wakes.
#[derive(Clone, Debug)]
pub(super) struct Propulsion {
    pub(super) rotors: Rotors,
    pub(super) battery: Battery,
    pub(super) mismatch: Mismatch,
    inflow: Inflow,
    ground: Ground,
    pub(super) wake: Wake,
    /// Thrust of each rotor, N.
    pub(super) thrust_n: PerRotor,
}

impl Propulsion {
    /// Propulsion of a vehicle that hovers with `hover_n` at each rotor. The seed decides how it differs from the assumed one.
    pub(super) fn new(vehicle: &VehicleSettings, hover_n: f64, seed: u64, dt_s: f64) -> Self {
        let (places, rotor) = (&vehicle.rotors, &vehicle.rotor);
        let mismatch = Mismatch::new(&vehicle.mismatch, seed);
        let command_n = hover_n / rotor.thrust_scale;
        let speed_rad_s = (command_n / rotor.thrust_coefficient_n_s2).sqrt();
        let power_w = rotor.torque_ratio_m * hover_n * speed_rad_s * places.len() as f64;
        let inflow = Inflow::new(rotor, hover_n, dt_s);
        let mut thrust_n = [0.0; MAX_ROTORS];
        thrust_n[..places.len()].fill(hover_n);
        Self {
            rotors: Rotors::new(places, rotor, &mismatch.ratios(), command_n, dt_s),
            battery: Battery::new(&vehicle.battery, power_w, dt_s),
            ground: Ground::new(places, seed, dt_s),
            wake: Wake::new(places, rotor.radius_m, &inflow.induced_m_s, dt_s),
            thrust_n,
            inflow,
            mismatch,
        }
    }

    /// Advances by a step under the command in force, N. Rotors follow the commands that have reached them.
    pub(super) fn step(
        &mut self,
        command_n: PerRotor,
        flow: &Flow,
        arena: &Arena,
        aero: &AeroSettings,
    ) -> RotorWrench {
        let (share, most_w) = (self.battery.speed_share(), self.battery.rotor_power_w());
        self.rotors.step(command_n, share, most_w);
        let mut height_m = [0.0; MAX_ROTORS];
        for (place, height) in self.rotors.places.iter().zip(&mut height_m) {
            let hub = flow.point(&Vector3::from(place.position_m));
            *height = hub.z - arena.height_below(&hub);
        }
        self.ground.step(&height_m, aero);
        let mut sum = RotorWrench::default();
        let mut power_w = 0.0;
        for i in 0..self.rotors.places.len() {
            power_w += self.add_rotor(i, flow, aero, &mut sum);
        }
        self.battery.step(power_w);
        self.wake.step(&flow.position, &flow.rotation, &self.inflow.induced_m_s, aero.wake_s);
        sum
    }

    /// Adds the loads of rotor `i` to `sum`; returns its mechanical power, W.
    fn add_rotor(
        &mut self,
        i: usize,
        flow: &Flow,
        aero: &AeroSettings,
        sum: &mut RotorWrench,
    ) -> f64 {
        let place = self.rotors.places[i];
        let hub = Vector3::from(place.position_m);
        let (speed, k) = (self.rotors.speed_rad_s(i), self.rotors.coefficient_n_s2(i));
        let [mut air, wind] = flow.through_air(&hub);
        air.z -= self.ground.again_m_s(i);
        let load = self.inflow.step(i, k, speed, &air, aero.inflow);
        let still_n = k * speed * speed;
        let thrust_n = load.thrust_n * (1.0 + self.ground.gain(i));
        self.thrust_n[i] = thrust_n;
        sum.thrust_n += still_n;
        sum.inflow_n += load.thrust_n - still_n;
        sum.ground_n += thrust_n - load.thrust_n;
        let mut in_plane = Vector3::zeros();
        if aero.rotor_drag {
            let per_speed = Vector3::from(aero.rotor_drag_n_s_m) * (thrust_n / DRAG_REFERENCE_N);
            let blown = per_speed.component_mul(&wind);
            in_plane = -per_speed.component_mul(&air);
            sum.drag += in_plane - blown;
            sum.wind += blown;
        }
        sum.moment += hub.cross(&(Vector3::new(0.0, 0.0, thrust_n) + in_plane));
        sum.moment.z -= place.spin * load.torque_n_m;
        if aero.flapping {
            // The disc tilts away from the cross flow and turns the hub with it.
            let across = Vector3::new(-air.y, air.x, 0.0);
            let stiffness = self.rotors.settings.flap_stiffness_n_m_rad;
            sum.moment -= across * (stiffness * load.flap_rad_s_m);
        }
        load.torque_n_m * speed
    }
}
