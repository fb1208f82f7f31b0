//! Splits the variance of a signal into bands of frequency, by the discrete Fourier transform of the whole signal.
//!
//! The split is exact: by Parseval's theorem the bands add up to the variance. The transform takes the signal as periodic, so a difference
//! `J` between its ends adds to the upper bands: over 300 s at most J² / 2900 above 0.5 Hz.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use serde::Serialize;

use twin_core::elementary::squared;
use twin_core::notation::TICK_S;

/// Frequencies between the bands, Hz; a line of the spectrum at such a frequency belongs to the band above it.
pub const EDGES_HZ: [f64; 2] = [0.5, 2.0];

/// Number of bands.
pub const BANDS: usize = EDGES_HZ.len() + 1;

/// Names of the bands.
pub const BAND_NAMES: [&str; BANDS] = ["< 0.5 Hz", "0.5-2 Hz", "> 2 Hz"];

/// Mean of a signal, and its variance by band.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Split {
    /// Mean, in the unit of the signal.
    pub mean: f64,
    /// Variance in each band, in the squared unit of the signal.
    pub variance: [f64; BANDS],
}

impl Split {
    /// The split of a signal with one value per tick.
    pub fn of(signal: impl Iterator<Item = f64>, planner: &mut FftPlanner<f64>) -> Self {
        let mut lines: Vec<Complex<f64>> = signal.map(Complex::from).collect();
        let n = lines.len();
        if n == 0 {
            return Self::default();
        }
        planner.plan_fft_forward(n).process(&mut lines);
        let mut variance = [0.0; BANDS];
        for (k, line) in lines.iter().enumerate().skip(1) {
            // Lines above half of the rate are those of negative frequencies.
            let hz = k.min(n - k) as f64 / (n as f64 * TICK_S);
            let band = EDGES_HZ.iter().filter(|edge| hz >= **edge).count();
            variance[band] += line.norm_sqr() / squared(n as f64);
        }
        Self { mean: lines[0].re / n as f64, variance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use twin_core::elementary::sin;

    /// A sine that does not end with a whole period leaks into its neighbours, and its mean square differs from half its squared amplitude.
    /// Over 240 s both are below 0.17 % for the slowest sine of the test: 1 / (π² (0.5 - 0.237) T) and 1 / (4π 0.237 T).
    const LEAK: f64 = 4e-3;

    fn split(signal: &[f64]) -> Split {
        Split::of(signal.iter().copied(), &mut FftPlanner::new())
    }

    #[test]
    fn a_sine_has_half_its_squared_amplitude_in_its_own_band() {
        // Periods that do not divide 240 s, and an odd number of ticks.
        let parts = [(0.237, 1.0), (1.1307, 0.8), (7.313, 0.5)];
        let value = |i: usize| {
            let t_s = i as f64 * TICK_S;
            let sines = parts.iter().map(|(hz, amplitude)| amplitude * sin(TAU * hz * t_s));
            5.0 + sines.sum::<f64>()
        };
        let found = split(&(0..24_001).map(value).collect::<Vec<_>>());
        // The slowest sine has a mean of at most 1 / (π 0.237 T).
        assert!((found.mean - 5.0).abs() < 0.006, "{found:?}");
        let whole: f64 = parts.iter().map(|(_, a)| a * a / 2.0).sum();
        for ((_, amplitude), variance) in parts.iter().zip(found.variance) {
            let expected = amplitude * amplitude / 2.0;
            assert!((variance - expected).abs() < LEAK * whole, "{expected} {found:?}");
        }
    }

    #[test]
    fn the_bands_add_up_to_the_variance() {
        // A ramp with a zigzag: no period fits it.
        let signal: Vec<f64> = (0..997).map(|i| f64::from(i) * 0.01 + f64::from(i % 7)).collect();
        let n = signal.len() as f64;
        let mean = signal.iter().sum::<f64>() / n;
        let variance = signal.iter().map(|v| squared(v - mean)).sum::<f64>() / n;
        let found = split(&signal);
        // A few thousand roundings of numbers near 10.
        assert!((found.variance.iter().sum::<f64>() / variance - 1.0).abs() < 1e-12);
        assert!((found.mean - mean).abs() < 1e-12);
    }

    #[test]
    fn a_line_at_an_edge_belongs_to_the_band_above() {
        let sine = |hz: f64| move |i: i32| sin(TAU * hz * f64::from(i) * TICK_S);
        for (band, hz) in EDGES_HZ.into_iter().enumerate() {
            let found = split(&(0..4000).map(sine(hz)).collect::<Vec<_>>());
            // Whole periods leak only by rounding.
            assert!((found.variance[band + 1] - 0.5).abs() < 1e-12, "{hz} Hz: {found:?}");
        }
        assert_eq!(split(&[]), Split::default());
    }
}
