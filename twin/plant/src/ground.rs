//! The air between rotors and a surface below them: ground effect, fountain and recirculation.
//!
//! In: heights of the hubs. Out: thrust ratio of each rotor, velocity of the air that it takes in again. State: the ratios, which follow
//! the heights late, and the unsteady velocities.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand::distr::Distribution;
use rand_pcg::Pcg64;

use super::settings::{AeroSettings, RotorPlace};
use twin_core::elementary::{exp, squared};
use twin_core::normal::StandardNormal;
use twin_core::notation::{MAX_ROTORS, PerRotor};

/// Separates this stream of random numbers from those of wind and sensors.
const STREAM: u64 = 0x9e0f_10d5;

/// Height in radii beyond which a surface has no effect: a rotor's own image adds 0.06 % there.
const HIGHEST_RADII: f64 = 10.0;

/// Smallest height in radii; at a quarter of a radius the formula has its pole.
const LOWEST_RADII: f64 = 0.5;

/// Largest share of thrust that the ground adds. The formula was fitted to measurements up to about this value.
const LARGEST_GAIN: f64 = 0.4;

/// Heights in radii over which the recirculation fades.
const RECIRCULATION_RADII: f64 = 2.0;

/// The air below the rotors.
#[derive(Clone, Debug)]
pub(super) struct Ground {
    /// Distance between two rotors, m.
    spacing_m: Vec<Vec<f64>>,
    /// Distance of the rotors that are farthest apart, m.
    span_m: f64,
    /// Share of thrust that the ground adds to each rotor.
    gain: PerRotor,
    /// Velocity of the air that each rotor takes in again, m/s, positive upwards.
    again_m_s: PerRotor,
    rng: Pcg64,
    dt_s: f64,
}

impl Ground {
    pub(super) fn new(places: &[RotorPlace], seed: u64, dt_s: f64) -> Self {
        let distance = |a: &RotorPlace, b: &RotorPlace| {
            (Vector3::from(a.position_m) - Vector3::from(b.position_m)).norm()
        };
        let spacing_m: Vec<Vec<f64>> =
            places.iter().map(|a| places.iter().map(|b| distance(a, b)).collect()).collect();
        let span_m = spacing_m.iter().flatten().copied().fold(0.0, f64::max);
        Self {
            spacing_m,
            span_m,
            gain: [0.0; MAX_ROTORS],
            again_m_s: [0.0; MAX_ROTORS],
            rng: Pcg64::seed_from_u64(seed ^ STREAM),
            dt_s,
        }
    }

    /// Advances by a step with the hubs at `height_m` above the surfaces below them.
    pub(super) fn step(&mut self, height_m: &PerRotor, s: &AeroSettings) {
        let blend = 1.0 - exp(-self.dt_s / s.ground_settling_s);
        for i in 0..self.spacing_m.len() {
            let target = if s.ground_effect { self.settled_gain(i, height_m, s) } else { 0.0 };
            self.gain[i] += (target - self.gain[i]) * blend;
        }
        self.recirculate(height_m, s);
    }

    /// Share of thrust that the ground adds to rotor `i` when the flow has settled. The thrust ratio is
    /// `1 / (1 - sum_j R^2/2 z_j / (d_ij^2 + 4 z_j^2)^(3/2) - 2 K_b R^2 z / (b^2 + 4 z^2)^(3/2))` with an image of every rotor `j` and the fountain `K_b`
    /// (Sanchez-Cuevas, Heredia and Ollero, "Characterization of the aerodynamic ground effect and its influence in multirotor control",
    /// International Journal of Aerospace Engineering 2017, equation 11). For one rotor alone it is Cheeseman and Bennett's (1955).
    fn settled_gain(&self, i: usize, height_m: &PerRotor, s: &AeroSettings) -> f64 {
        let radius_m = s.ground_effect_radius_m;
        if radius_m <= 0.0 || height_m[i] > HIGHEST_RADII * radius_m {
            return 0.0;
        }
        let image = |spacing_m: f64, height_m: f64| {
            let z = height_m.max(LOWEST_RADII * radius_m);
            let square = squared(spacing_m) + 4.0 * squared(z);
            0.5 * squared(radius_m) * z / (square * square.sqrt())
        };
        let images: f64 =
            self.spacing_m[i].iter().zip(height_m).map(|(spacing, z)| image(*spacing, *z)).sum();
        let several = if self.spacing_m.len() > 1 { 4.0 * s.fountain } else { 0.0 };
        let taken = images + several * image(self.span_m, height_m[i]);
        1.0 / (1.0 - taken.min(LARGEST_GAIN / (1.0 + LARGEST_GAIN))) - 1.0
    }

    /// Draws the velocities of the air that is taken in again.
    fn recirculate(&mut self, height_m: &PerRotor, s: &AeroSettings) {
        let radius_m = s.ground_effect_radius_m;
        let decay = exp(-self.dt_s / s.turbulence_s);
        let spread = (1.0 - decay * decay).sqrt();
        let rotors = self.spacing_m.len();
        for (again, height) in self.again_m_s.iter_mut().zip(height_m).take(rotors) {
            let near = radius_m > 0.0 && *height < HIGHEST_RADII * radius_m;
            if !(s.recirculation && near) {
                *again *= decay;
                continue;
            }
            let radii = (height / radius_m - 1.0).max(0.0);
            let std_m_s = s.recirculation_m_s * exp(-radii / RECIRCULATION_RADII);
            let n: f64 = StandardNormal.sample(&mut self.rng);
            *again = *again * decay + std_m_s * spread * n;
        }
    }

    /// Share of thrust that the ground adds to rotor `i`.
    pub(super) fn gain(&self, i: usize) -> f64 {
        self.gain[i]
    }

    /// Velocity of the air that rotor `i` takes in again, m/s, positive upwards along its axis.
    pub(super) fn again_m_s(&self, i: usize) -> f64 {
        self.again_m_s[i]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{AERO, quad};

    const STEP_S: f64 = 1e-3;

    fn settings() -> AeroSettings {
        AeroSettings { ground_effect: true, ..AERO }
    }

    #[test]
    fn one_rotor_meets_cheeseman_and_bennett() {
        let one = &quad()[..1];
        let mut ground = Ground::new(one, 1, STEP_S);
        for radii in [1.0, 2.0, 4.0] {
            let height_m = [radii * AERO.ground_effect_radius_m; MAX_ROTORS];
            (0..3000).for_each(|_| ground.step(&height_m, &settings()));
            let wanted = 1.0 / (1.0 - squared(1.0 / (4.0 * radii))) - 1.0;
            assert!((ground.gain(0) - wanted).abs() < 1e-9, "{radii}: {}", ground.gain(0));
        }
    }

    #[test]
    fn a_quadrotor_meets_the_published_formula_and_follows_late() {
        let mut ground = Ground::new(&quad(), 1, STEP_S);
        let (r, z, d) = (AERO.ground_effect_radius_m, 0.4_f64, 0.46_f64);
        let cubed = |x: f64| x * x * x;
        let term = |square: f64| z / cubed(square + 4.0 * z * z).sqrt();
        // Equation 11 written out for four rotors at distance d, with b = sqrt(2) d and K_b = 2.
        let lost = squared(r / (4.0 * z))
            + r * r * term(d * d)
            + 0.5 * r * r * term(2.0 * d * d)
            + 2.0 * r * r * term(2.0 * d * d) * 2.0;
        let wanted = 1.0 / (1.0 - lost) - 1.0;
        let settling = (AERO.ground_settling_s / STEP_S).round() as usize;
        (0..settling).for_each(|_| ground.step(&[z; MAX_ROTORS], &settings()));
        assert!((ground.gain(2) / wanted - (1.0 - exp(-1.0_f64))).abs() < 1e-9);
        (0..3000).for_each(|_| ground.step(&[z; MAX_ROTORS], &settings()));
        assert!((ground.gain(2) / wanted - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_rotor_beside_the_table_gains_less_than_one_above_it() {
        let mut ground = Ground::new(&quad(), 1, STEP_S);
        let mut height_m = [0.3; MAX_ROTORS];
        height_m[2] = 0.85;
        (0..3000).for_each(|_| ground.step(&height_m, &settings()));
        assert!(ground.gain(0) > 2.0 * ground.gain(2));
    }

    #[test]
    fn recirculation_has_its_standard_deviation_near_the_ground_and_none_high_above() {
        let s = AeroSettings { recirculation: true, ..AERO };
        let mut ground = Ground::new(&quad(), 1, STEP_S);
        let near = [AERO.ground_effect_radius_m; MAX_ROTORS];
        let steps = 600_000;
        let mut sum = 0.0;
        for _ in 0..steps {
            ground.step(&near, &s);
            sum += squared(ground.again_m_s(0));
        }
        let std = (sum / f64::from(steps)).sqrt();
        // 600 s at a correlation time of 0.3 s are 1000 independent samples: three standard errors are 7 %.
        assert!((std / AERO.recirculation_m_s - 1.0).abs() < 0.07, "{std}");
        (0..20_000).for_each(|_| ground.step(&[50.0; MAX_ROTORS], &s));
        assert!(ground.again_m_s(0).abs() < 1e-9);
    }
}
