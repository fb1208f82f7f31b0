//! Discrete filters on coordinate vectors. No state is shared between instances.

use crate::elementary::{exp, tan};
use std::f64::consts::{PI, SQRT_2};

use nalgebra::SVector;

/// 2nd-order Butterworth low-pass on `D` channels (bilinear transform with prewarping, direct form II transposed).
#[derive(Clone, Copy, Debug)]
pub struct Butterworth<const D: usize> {
    b: [f64; 3],
    a: [f64; 2],
    z: [SVector<f64, D>; 2],
}

impl<const D: usize> Butterworth<D> {
    /// A filter with corner frequency `corner_hz`, Hz, at sample period `dt_s`, s. Its state starts at rest at zero.
    pub fn new(corner_hz: f64, dt_s: f64) -> Self {
        let k = tan(PI * corner_hz * dt_s);
        let norm = 1.0 / (1.0 + SQRT_2 * k + k * k);
        Self {
            b: [k * k * norm, 2.0 * k * k * norm, k * k * norm],
            a: [2.0 * (k * k - 1.0) * norm, (1.0 - SQRT_2 * k + k * k) * norm],
            z: [SVector::zeros(); 2],
        }
    }

    /// Sets the state to the steady state for the input `value`.
    pub fn settle(&mut self, value: &SVector<f64, D>) {
        self.z[0] = value * (1.0 - self.b[0]);
        self.z[1] = value * (self.b[2] - self.a[1]);
    }

    /// Filters one sample.
    pub fn step(&mut self, x: &SVector<f64, D>) -> SVector<f64, D> {
        let y = x * self.b[0] + self.z[0];
        self.z[0] = x * self.b[1] - y * self.a[0] + self.z[1];
        self.z[1] = x * self.b[2] - y * self.a[1];
        y
    }
}

/// First-order low-pass (exact discretisation) on `D` channels.
#[derive(Clone, Copy, Debug)]
pub struct LowPass<const D: usize> {
    value: Option<SVector<f64, D>>,
}

impl<const D: usize> LowPass<D> {
    /// A filter that takes its first input as its state.
    pub const fn new() -> Self {
        Self { value: None }
    }

    /// Filters one sample of `x` with corner frequency `corner_hz`, Hz, at sample period `dt_s`, s.
    pub fn step(&mut self, x: &SVector<f64, D>, corner_hz: f64, dt_s: f64) -> SVector<f64, D> {
        let blend = 1.0 - exp(-2.0 * PI * corner_hz * dt_s);
        let y = self.value.map_or(*x, |v| v + (x - v) * blend);
        self.value = Some(y);
        y
    }

    /// Sets the state to `value`.
    pub fn jump(&mut self, value: &SVector<f64, D>) {
        self.value = Some(*value);
    }

    /// Clears the state; the next input becomes the state.
    pub fn reset(&mut self) {
        self.value = None;
    }
}

impl<const D: usize> Default for LowPass<D> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::{cos, powi, sin};
    use nalgebra::{Complex, Vector1};

    /// 0.1 %: the rest of the transient after 20 periods, and the error of the sampled amplitude.
    const AMPLITUDE_TOLERANCE: f64 = 1e-3;

    #[test]
    fn gain_equals_the_analogue_butterworth_at_the_prewarped_frequency() {
        let (corner_hz, dt_s) = (8.0, 1e-3);
        for f_hz in [1.0, 4.0, 8.0, 16.0, 40.0] {
            let mut filter = Butterworth::<1>::new(corner_hz, dt_s);
            let mut response = Complex::new(0.0, 0.0);
            let n = (20.0 / f_hz / dt_s).round() as usize;
            for i in 0..2 * n {
                let phase = 2.0 * PI * f_hz * dt_s * i as f64;
                let y = filter.step(&Vector1::new(sin(phase))).x;
                if i >= n {
                    response += Complex::new(y * sin(phase), y * cos(phase)) * (2.0 / n as f64);
                }
            }
            let warped = tan(PI * f_hz * dt_s) / tan(PI * corner_hz * dt_s);
            let expected = 1.0 / (1.0 + powi(warped, 4)).sqrt();
            assert!(
                (response.norm() - expected).abs() < AMPLITUDE_TOLERANCE,
                "{f_hz} Hz: {}",
                response.norm()
            );
        }
    }

    #[test]
    fn a_settled_filter_passes_its_value_unchanged() {
        let mut filter = Butterworth::<1>::new(8.0, 1e-3);
        filter.settle(&Vector1::new(30.0));
        for _ in 0..100 {
            assert!((filter.step(&Vector1::new(30.0)).x - 30.0).abs() < 1e-12);
        }
    }

    #[test]
    fn low_pass_reaches_63_percent_after_its_time_constant() {
        let mut filter = LowPass::<1>::new();
        filter.step(&Vector1::new(0.0), 5.0, 1e-3);
        let tau_steps = (1.0 / (2.0 * PI * 5.0) / 1e-3_f64).round() as usize;
        let y = (0..tau_steps).fold(0.0, |_, _| filter.step(&Vector1::new(1.0), 5.0, 1e-3).x);
        assert!((y - (1.0 - exp(-1.0_f64))).abs() < 0.01, "{y}");
    }
}
