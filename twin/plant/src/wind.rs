//! Wind at the vehicle: constant, gusts, Dryden turbulence.

use nalgebra::Vector3;
use rand::Rng;
use rand::distr::Distribution;

use super::settings::{WindKind, WindSettings};
use twin_core::elementary::{cos, exp};
use twin_core::normal::StandardNormal;

/// Wind with the state of its turbulence.
#[derive(Clone, Debug)]
pub(super) struct Wind {
    pub(super) settings: WindSettings,
    turbulence: Vector3<f64>,
}

impl Wind {
    pub(super) fn new(settings: &WindSettings) -> Self {
        Self { settings: *settings, turbulence: Vector3::zeros() }
    }

    /// Wind velocity in the world at `t_s`, m/s, for a vehicle moving at `speed_m_s`.
    pub(super) fn step(
        &mut self,
        t_s: f64,
        speed_m_s: f64,
        dt_s: f64,
        rng: &mut impl Rng,
    ) -> Vector3<f64> {
        let s = &self.settings;
        let mean = Vector3::from(s.velocity_m_s);
        match s.kind {
            WindKind::Constant => mean,
            WindKind::Gust => {
                let phase = t_s.rem_euclid(s.gust_period_s.max(s.gust_s));
                let along = if mean.norm() > 0.0 { mean.normalize() } else { Vector3::x() };
                let rise = if phase < s.gust_s {
                    0.5 * (1.0 - cos(std::f64::consts::TAU * phase / s.gust_s))
                } else {
                    0.0
                };
                mean + along * (s.gust_m_s * rise)
            }
            WindKind::Dryden => {
                // First-order Dryden form: time constant = scale length / air speed, exact discretisation.
                let air_speed = (mean.norm() + speed_m_s).max(0.5);
                let decay = exp(-dt_s * air_speed / s.scale_m);
                let spread = s.turbulence_m_s * (1.0 - decay * decay).sqrt();
                self.turbulence = self.turbulence.map(|u| {
                    let n: f64 = StandardNormal.sample(rng);
                    u * decay + spread * n
                });
                mean + self.turbulence
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use twin_core::elementary::squared;

    fn settings(kind: WindKind) -> WindSettings {
        WindSettings {
            kind,
            velocity_m_s: [2.0, 0.0, 0.0],
            gust_m_s: 3.0,
            gust_s: 2.0,
            gust_period_s: 10.0,
            turbulence_m_s: 1.0,
            scale_m: 1.0,
        }
    }

    #[test]
    fn a_gust_peaks_in_its_middle_and_ends() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let mut wind = Wind::new(&settings(WindKind::Gust));
        assert!((wind.step(1.0, 0.0, 1e-3, &mut rng).x - 5.0).abs() < 1e-12);
        assert!((wind.step(5.0, 0.0, 1e-3, &mut rng).x - 2.0).abs() < 1e-12);
    }

    #[test]
    fn dryden_turbulence_has_the_asked_standard_deviation() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let mut wind = Wind::new(&settings(WindKind::Dryden));
        let n = 400_000;
        let variance = (0..n)
            .map(|i| squared(wind.step(f64::from(i) * 0.01, 0.0, 0.01, &mut rng).y))
            .sum::<f64>()
            / f64::from(n);
        // 4000 s at a time constant of 0.5 s: about 4000 independent samples, 5 % is over three standard errors.
        assert!((variance.sqrt() - 1.0).abs() < 0.05, "{variance}");
    }
}
