//! Rotors: transport delay, speed lag, thrust curve and reaction torque. The loop's model of delay and lag runs beside them.

use std::collections::VecDeque;

use nalgebra::Vector3;

use super::settings::{RotorPlace, RotorSettings};
use twin_core::elementary::exp;
use twin_core::notation::{MAX_ROTORS, PerRotor};

/// A queue that delays the commands to an actuator.
#[derive(Clone, Debug)]
pub(super) struct Delay<T> {
    line: VecDeque<T>,
}

impl<T: Clone> Delay<T> {
    /// A delay of `delay_s` in steps of `dt_s`; the queue is full of `initial`.
    pub(super) fn new(delay_s: f64, dt_s: f64, initial: T) -> Self {
        let steps = (delay_s / dt_s).round().clamp(0.0, 1e4) as usize;
        Self { line: vec![initial; steps].into() }
    }

    pub(super) fn step(&mut self, value: T) -> T {
        self.line.push_back(value.clone());
        self.line.pop_front().unwrap_or(value)
    }
}

/// Delay and first-order lag of the rotor speed.
#[derive(Clone, Debug)]
struct Drive {
    delay: Delay<PerRotor>,
    speed_rad_s: PerRotor,
    lag_s: f64,
}

impl Drive {
    fn step(&mut self, command_n: PerRotor, settings: &RotorSettings, dt_s: f64) -> PerRotor {
        let command_n = self.delay.step(command_n);
        let blend = 1.0 - exp(-dt_s / self.lag_s);
        let mut thrust_n = [0.0; MAX_ROTORS];
        for i in 0..MAX_ROTORS {
            let wanted = (command_n[i].clamp(0.0, settings.max_thrust_n)
                / settings.thrust_coefficient_n_s2)
                .sqrt();
            self.speed_rad_s[i] += (wanted - self.speed_rad_s[i]) * blend;
            thrust_n[i] =
                settings.thrust_coefficient_n_s2 * self.speed_rad_s[i] * self.speed_rad_s[i];
        }
        thrust_n
    }
}

/// All rotors of the vehicle.
#[derive(Clone, Debug)]
pub(super) struct Rotors {
    pub(super) places: Vec<RotorPlace>,
    pub(super) settings: RotorSettings,
    real: Drive,
    modelled: Drive,
    /// Thrust of each rotor as a fraction of a healthy rotor's thrust.
    pub(super) efficiency: PerRotor,
    /// True thrust before aerodynamics, N.
    pub(super) thrust_n: PerRotor,
    /// Thrust that the loop's model gives, N.
    pub(super) modelled_thrust_n: PerRotor,
}

impl Rotors {
    /// Rotors that turn at the speed for a thrust of `hover_n` each.
    pub(super) fn new(
        places: &[RotorPlace],
        settings: &RotorSettings,
        hover_n: f64,
        dt_s: f64,
    ) -> Self {
        let mut command_n = [0.0; MAX_ROTORS];
        command_n[..places.len()].fill(hover_n);
        let speed_rad_s = command_n.map(|n| (n / settings.thrust_coefficient_n_s2).sqrt());
        let drive = |lag_s| Drive {
            delay: Delay::new(settings.delay_s, dt_s, command_n),
            speed_rad_s,
            lag_s,
        };
        Self {
            places: places.to_vec(),
            settings: *settings,
            real: drive(settings.lag_s),
            modelled: drive(settings.modelled_lag_s),
            efficiency: [1.0; MAX_ROTORS],
            thrust_n: command_n,
            modelled_thrust_n: command_n,
        }
    }

    pub(super) fn step(&mut self, command_n: PerRotor, dt_s: f64) {
        let healthy_n =
            self.real.step(command_n, &self.settings, dt_s).map(|n| n * self.settings.thrust_scale);
        self.thrust_n = std::array::from_fn(|rotor| healthy_n[rotor] * self.efficiency[rotor]);
        self.modelled_thrust_n = self.modelled.step(command_n, &self.settings, dt_s);
    }

    /// Speed of rotor `i`, rad/s.
    pub(super) fn speed_rad_s(&self, i: usize) -> f64 {
        self.real.speed_rad_s[i]
    }

    /// Collective thrust and moment about the root link's origin in the body frame for given thrusts, N and N m.
    pub(super) fn wrench(&self, thrust_n: &PerRotor) -> (f64, Vector3<f64>) {
        self.places.iter().zip(thrust_n).fold(
            (0.0, Vector3::zeros()),
            |(total, moment), (place, n)| {
                let arm = Vector3::from(place.position_m).cross(&Vector3::new(0.0, 0.0, *n));
                let reaction = -place.spin * self.settings.torque_ratio_m * n;
                (total + n, moment + arm + Vector3::new(0.0, 0.0, reaction))
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::elementary::squared;

    fn settings() -> RotorSettings {
        RotorSettings {
            radius_m: 0.178,
            min_thrust_n: 0.3,
            max_thrust_n: 15.0,
            torque_ratio_m: 0.018,
            thrust_coefficient_n_s2: 4.3e-5,
            lag_s: 0.04,
            delay_s: 0.005,
            thrust_scale: 0.97,
            modelled_lag_s: 0.04,
        }
    }

    fn quad() -> Vec<RotorPlace> {
        [(1.0, 1.0, 1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0), (1.0, -1.0, -1.0)]
            .map(|(x, y, spin)| RotorPlace { position_m: [0.23 * x, 0.23 * y, 0.0], spin })
            .to_vec()
    }

    #[test]
    fn a_step_waits_for_the_delay_then_follows_the_lag() {
        let dt = 1e-3;
        let mut rotors = Rotors::new(&quad(), &settings(), 4.0, dt);
        let command = {
            let mut c = [0.0; MAX_ROTORS];
            c[..4].fill(9.0);
            c
        };
        for _ in 0..5 {
            rotors.step(command, dt);
            assert!(
                (rotors.modelled_thrust_n[0] - 4.0).abs() < 1e-12,
                "nothing moves within the delay"
            );
        }
        (0..40).for_each(|_| rotors.step(command, dt));
        // Speed follows 1 - exp(-t/lag): sqrt(T) = 2 + (3 - 2)(1 - 1/e) after one time constant.
        let expected = squared(2.0 + (1.0 - exp(-1.0_f64)));
        assert!((rotors.modelled_thrust_n[0] - expected).abs() < 1e-9);
        assert!((rotors.thrust_n[0] - 0.97 * expected).abs() < 1e-9);
    }

    #[test]
    fn equal_thrusts_make_no_moment_and_spin_decides_yaw() {
        let rotors = Rotors::new(&quad(), &settings(), 5.0, 1e-3);
        let mut thrust = [0.0; MAX_ROTORS];
        thrust[..4].fill(5.0);
        let (total, moment) = rotors.wrench(&thrust);
        assert!((total - 20.0).abs() < 1e-12 && moment.norm() < 1e-12);
        thrust[0] = 6.0;
        assert!(
            rotors.wrench(&thrust).1.z < 0.0,
            "a counter-clockwise rotor pushes the body clockwise"
        );
    }
}
