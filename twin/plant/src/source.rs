//! The simulated vehicle as a [`Source`]: ten steps of 1 ms a tick, with the inner controllers at every second step.

use nalgebra::Vector3;

use super::truth::truth;
use super::vehicle::SimulatedVehicle;
use super::{STEP_S, STEPS_PER_TICK};
use twin_core::notation::Coords;
use twin_core::source::{Disturbance, InnerLoop, InnerState, Source};
use twin_core::tick::{GripperReading, Measurement, Setpoint, Truth};

impl SimulatedVehicle {
    /// Switches an effect of this name, if there is one.
    fn switch(&mut self, name: &str, on: bool) {
        let Some(switch) = self.settings.effect_mut(name) else { return };
        *switch = on;
        // Each part owns a copy of its settings.
        self.aero.settings = self.settings.aero;
        self.wind.settings.on = self.settings.wind.on;
        self.servos.settings = self.settings.vehicle.servo;
        self.sensors.settings = self.settings.sensors;
        self.propulsion.battery.settings = self.settings.vehicle.battery;
        self.propulsion.mismatch.switch(self.settings.vehicle.mismatch.on);
        let ratios = self.propulsion.mismatch.ratios();
        self.propulsion.rotors.differ(&ratios);
    }
}

impl Source for SimulatedVehicle {
    fn advance(&mut self, setpoint: &Setpoint, inner: &mut dyn InnerLoop) -> Measurement {
        let mut saturated = false;
        let mut filtered = (Coords::zeros(), Coords::zeros());
        let mut state = self.state();
        for _ in 0..STEPS_PER_TICK {
            if self.step.is_multiple_of(self.inner_steps) && !self.failures.stalled {
                let (chi, chi_dot) = (self.estimator.chi(), self.estimator.chi_dot());
                let view = InnerState {
                    eta: chi.fixed_rows::<3>(3).into_owned(),
                    eta_dot: chi_dot.fixed_rows::<3>(3).into_owned(),
                    joint: chi.fixed_rows::<2>(6).into_owned(),
                    joint_dot: chi_dot.fixed_rows::<2>(6).into_owned(),
                };
                self.command = inner.command(setpoint, &view);
                saturated |= self.command.saturated;
                self.send_command();
            }
            self.step_world(&state, setpoint);
            state = self.state();
            filtered = self.sense(&state);
        }
        Measurement {
            t_s: self.step as f64 * STEP_S,
            chi: self.estimator.chi().into(),
            chi_dot: self.estimator.chi_dot().into(),
            chi_ddot: filtered.0.into(),
            tau_applied: filtered.1.into(),
            gripper: self.gripper.as_ref().map_or_else(GripperReading::default, |g| {
                g.reading(&self.world, &self.articulation)
            }),
            payload: self.payload_seen,
            saturated,
            airborne: true,
        }
    }

    fn truth(&self) -> Option<Truth> {
        Some(truth(self))
    }

    fn disturb(&mut self, disturbance: &Disturbance) {
        match disturbance {
            Disturbance::PayloadMass { kg } => {
                self.settings.payload.mass_kg = *kg;
                self.arena.set_payload(&mut self.world, &self.settings.payload);
            }
            Disturbance::Wind { velocity_m_s } => self.wind.settings.velocity_m_s = *velocity_m_s,
            Disturbance::Push { force_n, duration_s } => {
                self.push = Some((Vector3::from(*force_n), *duration_s));
            }
            // The friction of the cube becomes zero, so its weight pulls it out of the closed fingers.
            Disturbance::DropPayload => self.set_grip_friction(0.0),
            Disturbance::Failure { failure, on } => self.fail(failure, *on),
            Disturbance::Effect { name, on } => self.switch(name, *on),
        }
    }
}
