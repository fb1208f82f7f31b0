//! Fifth-order segments: position, rate and acceleration are continuous at both ends.

use crate::elementary::powi;
use nalgebra::SVector;

/// A point of a trajectory with its two derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot<const D: usize> {
    /// Value.
    pub value: SVector<f64, D>,
    /// First derivative, per s.
    pub rate: SVector<f64, D>,
    /// Second derivative, per s².
    pub acceleration: SVector<f64, D>,
}

impl<const D: usize> Knot<D> {
    /// A knot at rest at `value`.
    pub fn rest(value: SVector<f64, D>) -> Self {
        Self { value, rate: SVector::zeros(), acceleration: SVector::zeros() }
    }
}

/// A quintic from any knot to a knot at rest.
#[derive(Clone, Copy, Debug)]
pub struct Quintic<const D: usize> {
    c: [SVector<f64, D>; 6],
    duration_s: f64,
}

impl<const D: usize> Quintic<D> {
    /// A quintic from `from` to rest at `to` in `duration_s`, s (at least 1 ms).
    pub fn to_rest(from: &Knot<D>, to: &SVector<f64, D>, duration_s: f64) -> Self {
        let t = duration_s.max(1e-3);
        let c2 = from.acceleration * 0.5;
        // The remaining boundary conditions at t, solved for the three highest coefficients.
        let p = to - from.value - from.rate * t - c2 * (t * t);
        let v = -from.rate - from.acceleration * t;
        let a = -from.acceleration;
        let c3 = (p * 10.0 - v * (4.0 * t) + a * (0.5 * t * t)) / powi(t, 3);
        let c4 = (p * -15.0 + v * (7.0 * t) - a * (t * t)) / powi(t, 4);
        let c5 = (p * 6.0 - v * (3.0 * t) + a * (0.5 * t * t)) / powi(t, 5);
        Self { c: [from.value, from.rate, c2, c3, c4, c5], duration_s: t }
    }

    /// Value and derivatives `t_s` seconds after the start; constant after the end.
    pub fn at(&self, t_s: f64) -> Knot<D> {
        let t = t_s.clamp(0.0, self.duration_s);
        let c = &self.c;
        let value = c[0] + (c[1] + (c[2] + (c[3] + (c[4] + c[5] * t) * t) * t) * t) * t;
        let rate = c[1] + (c[2] * 2.0 + (c[3] * 3.0 + (c[4] * 4.0 + c[5] * (5.0 * t)) * t) * t) * t;
        let acceleration = c[2] * 2.0 + (c[3] * 6.0 + (c[4] * 12.0 + c[5] * (20.0 * t)) * t) * t;
        if t_s >= self.duration_s { Knot::rest(value) } else { Knot { value, rate, acceleration } }
    }

    /// Duration, s.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn boundary_conditions_hold_and_derivatives_are_derivatives(
            p0 in -2.0..2.0f64, v0 in -1.0..1.0f64, a0 in -2.0..2.0f64, p1 in -2.0..2.0f64, t in 0.5..5.0f64, u in 0.1..0.9f64
        ) {
            let from = Knot { value: Vector1::new(p0), rate: Vector1::new(v0), acceleration: Vector1::new(a0) };
            let q = Quintic::to_rest(&from, &Vector1::new(p1), t);
            let (start, end) = (q.at(0.0), q.at(t - 1e-9));
            prop_assert!((start.value - from.value).norm() + (start.rate - from.rate).norm() < 1e-12);
            // The end is evaluated 1 ns early, at which the acceleration differs by jerk times 1 ns.
            prop_assert!((end.value.x - p1).abs() < 1e-6 && end.rate.x.abs() < 1e-6 && end.acceleration.x.abs() < 1e-4);
            // Central differences with step 1e-4 s have an error below 1e-5 for these coefficients.
            let h = 1e-4;
            let (before, here, after) = (q.at(u * t - h), q.at(u * t), q.at(u * t + h));
            let scale = 1.0 + here.acceleration.x.abs() + here.rate.x.abs();
            prop_assert!(((after.value.x - before.value.x) / (2.0 * h) - here.rate.x).abs() < 1e-4 * scale);
            prop_assert!(((after.rate.x - before.rate.x) / (2.0 * h) - here.acceleration.x).abs() < 1e-3 * scale);
        }
    }
}
