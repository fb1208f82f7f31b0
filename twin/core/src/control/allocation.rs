//! Allocation: thrust of each rotor from the collective thrust and the body moment. If the demand does not fit, yaw yields first.

use nalgebra::{DMatrix, Vector3};

use crate::notation::{MAX_ROTORS, PerRotor};

/// The rotor data that the allocation needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotor {
    /// Position in the body frame, m.
    pub position_in_body: Vector3<f64>,
    /// Signed reaction torque about body z per thrust, m.
    pub torque_per_thrust_m: f64,
}

/// Singular values of the mixing matrix below this are taken for zero.
const SINGULAR: f64 = 1e-12;

/// Pseudo-inverse of the mixing matrix and the thrust limits.
#[derive(Clone, Debug)]
pub struct Allocation {
    n: usize,
    inverse: DMatrix<f64>,
    min_n: f64,
    max_n: f64,
}

impl Allocation {
    /// An allocation for rotors that push along body z, with thrust limits in N, the lower one below the upper one. Rotors beyond
    /// [`MAX_ROTORS`] are ignored.
    pub fn new(rotors: &[Rotor], min_n: f64, max_n: f64) -> Self {
        let n = rotors.len().min(MAX_ROTORS);
        let mixing = DMatrix::from_fn(4, n, |row, i| {
            let p = rotors[i].position_in_body;
            [1.0, p.y, -p.x, rotors[i].torque_per_thrust_m][row]
        });
        // Without rotors there is no matrix to invert.
        let inverse = if n == 0 { None } else { mixing.pseudo_inverse(SINGULAR).ok() };
        let inverse = inverse.unwrap_or_else(|| DMatrix::zeros(n, 4));
        Self { n, inverse, min_n, max_n }
    }

    /// Rotor thrusts (N) for a collective thrust and a body moment; NaN for a demand that is not finite or overflows. The second value
    /// is true if the demand did not fit. Roll and pitch then keep their moment as long as possible, the collective thrust moves to
    /// make room, and yaw gets the rest.
    pub fn allocate(&self, thrust_n: f64, moment_n_m: &Vector3<f64>) -> (PerRotor, bool) {
        if self.n == 0 {
            return ([0.0; MAX_ROTORS], true);
        }
        let column = |axis: usize, value: f64| self.inverse.column(axis) * value;
        let tilt = column(1, moment_n_m.x) + column(2, moment_n_m.y);
        let demand = [thrust_n, moment_n_m.z];
        if !tilt.iter().chain(&demand).all(|x| x.is_finite()) {
            return ([f64::NAN; MAX_ROTORS], true);
        }
        let lift = column(0, 1.0);
        let (low, high) = (tilt.min(), tilt.max());
        let span = self.max_n - self.min_n;
        let tilt_scale = if high - low > span { span / (high - low) } else { 1.0 };
        let tilt = tilt * tilt_scale;
        // Collective range in which every rotor stays within its limits; rotors share the lift equally on a symmetric frame.
        let share = lift.sum() / self.n.max(1) as f64;
        let share = if share > 0.0 { share } else { 1.0 };
        let least = (self.min_n - tilt.min()) / share;
        let most = (self.max_n - tilt.max()) / share;
        let collective = thrust_n.clamp(least.min(most), most.max(least));
        let base = tilt + lift * collective;
        let yaw = column(3, moment_n_m.z);
        let yaw_scale = self.largest_fit(base.as_slice(), yaw.as_slice());
        let mut out = [0.0; MAX_ROTORS];
        for (i, value) in out.iter_mut().enumerate().take(self.n) {
            *value = (base[i] + yaw[i] * yaw_scale).clamp(self.min_n, self.max_n);
        }
        let given_up = tilt_scale < 1.0 || yaw_scale < 1.0 || (collective - thrust_n).abs() > 1e-9;
        (out, given_up)
    }

    /// Largest factor in 0..=1 with which `extra` can be added to `base` within the limits.
    fn largest_fit(&self, base: &[f64], extra: &[f64]) -> f64 {
        base.iter().zip(extra).fold(1.0_f64, |factor, (b, e)| {
            let room = if *e > 0.0 { self.max_n - b } else { b - self.min_n };
            if e.abs() > 1e-12 { factor.min((room / e.abs()).max(0.0)) } else { factor }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ARM_M: f64 = 0.23;
    const KAPPA_M: f64 = 0.018;

    fn rotors() -> Vec<Rotor> {
        [(1.0, 1.0, -1.0), (-1.0, 1.0, 1.0), (-1.0, -1.0, -1.0), (1.0, -1.0, 1.0)]
            .map(|(x, y, spin)| Rotor {
                position_in_body: Vector3::new(x * ARM_M, y * ARM_M, 0.0),
                torque_per_thrust_m: -spin * KAPPA_M,
            })
            .to_vec()
    }

    /// Collective thrust and moment of the rotor thrusts, computed directly from the geometry.
    fn wrench(thrust: &PerRotor) -> (f64, Vector3<f64>) {
        rotors().iter().zip(thrust).fold((0.0, Vector3::zeros()), |(total, moment), (rotor, f)| {
            let arm = rotor.position_in_body.cross(&Vector3::new(0.0, 0.0, *f));
            (total + f, moment + arm + Vector3::z() * (rotor.torque_per_thrust_m * f))
        })
    }

    proptest! {
        #[test]
        fn mixing_undoes_allocation_when_it_fits(t in 25.0..35.0f64, x in -0.8..0.8f64, y in -0.8..0.8f64, z in -0.1..0.1f64) {
            let allocation = Allocation::new(&rotors(), 0.3, 15.0);
            let moment = Vector3::new(x, y, z);
            let (thrust, given_up) = allocation.allocate(t, &moment);
            let (total, made) = wrench(&thrust);
            prop_assert!(!given_up);
            prop_assert!((total - t).abs() < 1e-9 && (made - moment).norm() < 1e-9);
        }

        #[test]
        fn limits_hold_and_roll_and_pitch_outlive_yaw(t in 0.0..80.0f64, x in -2.0..2.0f64, y in -2.0..2.0f64, z in -5.0..5.0f64) {
            let allocation = Allocation::new(&rotors(), 0.3, 15.0);
            let (thrust, _) = allocation.allocate(t, &Vector3::new(x, y, z));
            prop_assert!(thrust[..4].iter().all(|f| (0.3..=15.0).contains(f)));
            let (_, made) = wrench(&thrust);
            prop_assert!((made.x - x).abs() < 1e-9 && (made.y - y).abs() < 1e-9, "roll and pitch were possible");
        }
    }
}
