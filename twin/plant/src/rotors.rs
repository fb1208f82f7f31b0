//! Rotors: the way from a commanded thrust to a rotor speed. The loop's model of delay and lag runs beside them.

use nalgebra::Vector3;

use super::command_link::CommandLink;
use super::mismatch::Ratios;
use super::settings::{RotorPlace, RotorSettings};
use twin_core::elementary::exp;
use twin_core::notation::{MAX_ROTORS, PerRotor};

/// First-order lag of rotor speeds, with the shares of a step by which a speed rises and falls towards the wanted one.
#[derive(Clone, Debug)]
struct Drive {
    speed_rad_s: PerRotor,
    rise: PerRotor,
    fall: PerRotor,
}

impl Drive {
    /// A drive with the time constants `rise_s` and `fall_s` times `ratio` of each rotor, in steps of `dt_s`.
    fn new(speed_rad_s: PerRotor, [rise_s, fall_s]: [f64; 2], ratio: &PerRotor, dt_s: f64) -> Self {
        let share = |lag_s: f64| ratio.map(|ratio| 1.0 - exp(-dt_s / (lag_s * ratio)));
        Self { speed_rad_s, rise: share(rise_s), fall: share(fall_s) }
    }

    fn step(&mut self, wanted_rad_s: &PerRotor) {
        for (i, wanted) in wanted_rad_s.iter().enumerate() {
            let gap = wanted - self.speed_rad_s[i];
            self.speed_rad_s[i] += gap * if gap > 0.0 { self.rise[i] } else { self.fall[i] };
        }
    }
}

/// All rotors of the vehicle.
#[derive(Clone, Debug)]
pub(super) struct Rotors {
    pub(super) places: Vec<RotorPlace>,
    pub(super) settings: RotorSettings,
    link: CommandLink<PerRotor>,
    real: Drive,
    /// The link as the loop assumes it: every command arrives, after the same delay.
    modelled_link: CommandLink<PerRotor>,
    modelled: Drive,
    /// Thrust of each rotor as a fraction of a healthy rotor's thrust.
    pub(super) efficiency: PerRotor,
    /// True thrust at a given speed per thrust that the settings give.
    thrust_ratio: PerRotor,
    /// Thrust that the loop's model gives, N.
    pub(super) modelled_thrust_n: PerRotor,
    dt_s: f64,
}

impl Rotors {
    /// Rotors that turn at the speed for a thrust of `hover_n` each.
    pub(super) fn new(
        places: &[RotorPlace],
        settings: &RotorSettings,
        ratios: &Ratios,
        hover_n: f64,
        dt_s: f64,
    ) -> Self {
        let mut command_n = [0.0; MAX_ROTORS];
        command_n[..places.len()].fill(hover_n);
        let speed_rad_s = command_n.map(|n| (n / settings.thrust_coefficient_n_s2).sqrt());
        let modelled_lags = [settings.modelled_lag_s; 2];
        let link = CommandLink::new(settings.delay_s, dt_s, command_n);
        let mut this = Self {
            places: places.to_vec(),
            settings: *settings,
            link: link.clone(),
            real: Drive::new(speed_rad_s, modelled_lags, &[1.0; MAX_ROTORS], dt_s),
            modelled_link: link,
            modelled: Drive::new(speed_rad_s, modelled_lags, &[1.0; MAX_ROTORS], dt_s),
            efficiency: [1.0; MAX_ROTORS],
            thrust_ratio: [1.0; MAX_ROTORS],
            modelled_thrust_n: command_n,
            dt_s,
        };
        this.differ(ratios);
        this
    }

    /// Lets the true rotors differ from the assumed ones by `ratios`.
    pub(super) fn differ(&mut self, ratios: &Ratios) {
        let s = &self.settings;
        let speed_rad_s = self.real.speed_rad_s;
        self.real = Drive::new(speed_rad_s, [s.lag_s, s.fall_lag_s], &ratios.rotor_lag, self.dt_s);
        self.thrust_ratio = ratios.rotor_thrust.map(|ratio| ratio * s.thrust_scale);
    }

    /// Takes a command from the loop, `late` by so many steps; `None` loses it on its way to the rotors.
    pub(super) fn command(&mut self, command_n: PerRotor, late: Option<u64>) {
        self.link.send(command_n, late);
    }

    /// Advances the speeds by a step. `share` is the speed per commanded speed that the battery allows, `power_w` the largest power of a
    /// rotor; `command_n` is the command in force, which the loop's model follows.
    pub(super) fn step(&mut self, command_n: PerRotor, share: f64, power_w: f64) {
        let s = self.settings;
        let wanted = |n: f64| (n.clamp(0.0, s.max_thrust_n) / s.thrust_coefficient_n_s2).sqrt();
        let most_rad_s = fastest(power_w, &s);
        self.real.step(&self.link.step().map(|n| (wanted(n) * share).min(most_rad_s)));
        self.modelled_link.send(command_n, Some(0));
        self.modelled.step(&self.modelled_link.step().map(wanted));
        self.modelled_thrust_n =
            self.modelled.speed_rad_s.map(|speed| s.thrust_coefficient_n_s2 * speed * speed);
    }

    /// Speed of rotor `i`, rad/s.
    pub(super) fn speed_rad_s(&self, i: usize) -> f64 {
        self.real.speed_rad_s[i]
    }

    /// Thrust of rotor `i` per squared speed in still air, N s²/rad².
    pub(super) fn coefficient_n_s2(&self, i: usize) -> f64 {
        self.settings.thrust_coefficient_n_s2 * self.thrust_ratio[i] * self.efficiency[i]
    }

    /// Collective thrust and moment about the root link's origin in the body frame for the modelled thrusts, N and N m.
    pub(super) fn modelled_wrench(&self) -> (f64, Vector3<f64>) {
        self.places.iter().zip(&self.modelled_thrust_n).fold(
            (0.0, Vector3::zeros()),
            |(total, moment), (place, n)| {
                let arm = Vector3::from(place.position_m).cross(&Vector3::new(0.0, 0.0, *n));
                let reaction = -place.spin * self.settings.torque_ratio_m * n;
                (total + n, moment + arm + Vector3::new(0.0, 0.0, reaction))
            },
        )
    }
}

/// Speed at which a rotor in hover takes `power_w`, rad/s: `P = kappa k Omega^3`.
fn fastest(power_w: f64, s: &RotorSettings) -> f64 {
    let per_cubed_speed = s.torque_ratio_m * s.thrust_coefficient_n_s2;
    if power_w.is_finite() && per_cubed_speed > 0.0 {
        twin_core::elementary::powf(power_w / per_cubed_speed, 1.0 / 3.0)
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{ROTOR, quad, ratios};
    use twin_core::elementary::squared;

    const STEP_S: f64 = 1e-3;

    fn rotors(ratios: &Ratios) -> Rotors {
        let settings = RotorSettings { lag_s: 0.03, fall_lag_s: 0.06, ..ROTOR };
        Rotors::new(&quad(), &settings, ratios, 4.0, STEP_S)
    }

    fn all(thrust_n: f64) -> PerRotor {
        let mut command = [0.0; MAX_ROTORS];
        command[..4].fill(thrust_n);
        command
    }

    fn advance(rotors: &mut Rotors, steps: usize, thrust_n: f64) {
        for _ in 0..steps {
            rotors.command(all(thrust_n), Some(0));
            rotors.step(all(thrust_n), 1.0, f64::INFINITY);
        }
    }

    /// Thrust in still air that a rotor gives at its speed.
    fn thrust_n(rotors: &Rotors, i: usize) -> f64 {
        rotors.coefficient_n_s2(i) * squared(rotors.speed_rad_s(i))
    }

    #[test]
    fn a_step_waits_for_the_delay_then_rises_and_falls_with_its_own_time_constant() {
        let mut rotors = rotors(&ratios());
        advance(&mut rotors, 5, 9.0);
        assert!((rotors.modelled_thrust_n[0] - 4.0).abs() < 1e-12, "the delay has not passed");
        assert!((thrust_n(&rotors, 0) - 0.97 * 4.0).abs() < 1e-12, "the delay has not passed");
        advance(&mut rotors, 30, 9.0);
        // Speed follows 1 - exp(-t/lag): sqrt(T) = 2 + (3 - 2)(1 - 1/e) after one time constant; the model has the longer one.
        let risen = 2.0 + (1.0 - exp(-1.0_f64));
        assert!((thrust_n(&rotors, 0) - 0.97 * squared(risen)).abs() < 1e-9);
        let modelled = 2.0 + (1.0 - exp(-30.0_f64 / 40.0));
        assert!((rotors.modelled_thrust_n[0] - squared(modelled)).abs() < 1e-9);
        advance(&mut rotors, 5, 4.0);
        let before = thrust_n(&rotors, 0).sqrt();
        advance(&mut rotors, 60, 4.0);
        let low = 0.97_f64.sqrt() * 2.0;
        let fallen = low + (before - low) * exp(-1.0_f64);
        assert!((thrust_n(&rotors, 0).sqrt() - fallen).abs() < 1e-9);
    }

    #[test]
    fn each_rotor_differs_by_its_own_ratio() {
        let mut different = ratios();
        different.rotor_thrust[1] = 1.05;
        different.rotor_lag[2] = 2.0;
        let mut rotors = rotors(&different);
        assert!((thrust_n(&rotors, 1) / thrust_n(&rotors, 0) - 1.05).abs() < 1e-12);
        advance(&mut rotors, 65, 9.0);
        let slow = 2.0 + (1.0 - exp(-1.0_f64));
        assert!((thrust_n(&rotors, 2) - 0.97 * squared(slow)).abs() < 1e-9);
        rotors.differ(&ratios());
        assert!((thrust_n(&rotors, 1) - thrust_n(&rotors, 0)).abs() < 1e-12);
    }

    #[test]
    fn battery_and_current_limit_lower_the_speed() {
        let mut rotors = rotors(&ratios());
        for _ in 0..2000 {
            rotors.command(all(9.0), Some(0));
            rotors.step(all(9.0), 0.9, f64::INFINITY);
        }
        assert!((thrust_n(&rotors, 0) - 0.97 * 9.0 * 0.81).abs() < 1e-9);
        // Power at 4 N: torque 0.018 m x 4 N times the speed.
        let power_w = 0.018 * 4.0 * (4.0 / ROTOR.thrust_coefficient_n_s2).sqrt();
        for _ in 0..2000 {
            rotors.command(all(9.0), Some(0));
            rotors.step(all(9.0), 1.0, power_w);
        }
        assert!((thrust_n(&rotors, 0) - 0.97 * 4.0).abs() < 1e-9);
    }

    #[test]
    fn equal_thrusts_make_no_moment_and_spin_decides_yaw() {
        let mut rotors = rotors(&ratios());
        rotors.modelled_thrust_n = all(5.0);
        let (total, moment) = rotors.modelled_wrench();
        assert!((total - 20.0).abs() < 1e-12 && moment.norm() < 1e-12);
        rotors.modelled_thrust_n[0] = 6.0;
        assert!(
            rotors.modelled_wrench().1.z < 0.0,
            "a counter-clockwise rotor pushes the body clockwise"
        );
    }
}
