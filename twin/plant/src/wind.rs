//! Wind around the vehicle: constant, gusts whose front passes over it, Dryden turbulence.

use nalgebra::Vector3;
use rand::Rng;
use rand::distr::Distribution;

use super::settings::{WindKind, WindSettings};
use twin_core::elementary::{cos, exp, powf, squared};
use twin_core::normal::StandardNormal;

/// Smallest speed with which a frozen turbulence field passes, m/s.
const SLOWEST_M_S: f64 = 0.5;

/// Metres of a foot: MIL-F-8785C counts in feet.
const FOOT_M: f64 = 0.3048;

/// Lowest altitude of the low-altitude model, m: 10 ft.
const LOWEST_M: f64 = 10.0 * FOOT_M;

/// The wind at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct WindNow {
    /// Wind without the gust, in the world, m/s.
    pub(super) even: Vector3<f64>,
    gust: Option<Gust>,
}

/// A row of gusts that travels.
#[derive(Clone, Copy, Debug)]
struct Gust {
    along: Vector3<f64>,
    peak_m_s: f64,
    length_s: f64,
    period_s: f64,
    front_m_s: f64,
    t_s: f64,
}

impl Gust {
    /// Velocity at `point`, m/s. The origin of the world meets the first gust at 0 s.
    fn at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        if self.length_s <= 0.0 {
            return Vector3::zeros();
        }
        let late_s = self.along.dot(point) / self.front_m_s;
        let phase = (self.t_s - late_s).rem_euclid(self.period_s);
        if phase >= self.length_s {
            return Vector3::zeros();
        }
        let rise = 0.5 * (1.0 - cos(std::f64::consts::TAU * phase / self.length_s));
        self.along * (self.peak_m_s * rise)
    }
}

impl WindNow {
    /// No wind.
    pub(super) const CALM: Self = Self { even: Vector3::new(0.0, 0.0, 0.0), gust: None };

    /// Wind in the world at `point`, m/s.
    pub(super) fn at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.gust.map_or(self.even, |gust| self.even + gust.at(point))
    }

    /// Adds a velocity everywhere, m/s.
    pub(super) fn plus(mut self, velocity: &Vector3<f64>) -> Self {
        self.even += velocity;
        self
    }
}

/// Wind with the state of its turbulence.
#[derive(Clone, Debug)]
pub(super) struct Wind {
    pub(super) settings: WindSettings,
    along: f64,
    across: [Transverse; 2],
}

/// State of the second-order filter of a transverse component: `(1 + sqrt(3) tau s) / (1 + tau s)^2`.
#[derive(Clone, Copy, Debug, Default)]
struct Transverse {
    first: f64,
    second: f64,
}

impl Transverse {
    /// The next value of unit variance after `share` time constants and a normal draw `n`.
    fn step(&mut self, share: f64, n: f64) -> f64 {
        let decay = exp(-share);
        // The white noise of unit density per time constant gives `first` the variance 1/2.
        self.first = self.first * decay + (0.5 * (1.0 - decay * decay)).sqrt() * n;
        self.second += (self.first - self.second) * (1.0 - decay);
        let root = 3.0_f64.sqrt();
        root * self.first + (1.0 - root) * self.second
    }
}

/// Standard deviations (m/s) and scale lengths (m) of turbulence along the wind, across it and vertically.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turbulence {
    pub(super) std_m_s: [f64; 3],
    pub(super) scale_m: [f64; 3],
}

/// Turbulence near the ground at `altitude_m` in a wind of `wind_m_s` at 20 ft (MIL-F-8785C, section 3.7.3.4).
pub(super) fn low_altitude(altitude_m: f64, wind_m_s: f64) -> Turbulence {
    let height = altitude_m.max(LOWEST_M);
    let base = 0.177 + 0.000_823 * height / FOOT_M;
    let vertical = 0.1 * wind_m_s;
    let horizontal = vertical / powf(base, 0.4);
    let long = height / powf(base, 1.2);
    Turbulence { std_m_s: [horizontal, horizontal, vertical], scale_m: [long, long, height] }
}

impl Wind {
    pub(super) fn new(settings: &WindSettings) -> Self {
        Self { settings: *settings, along: 0.0, across: [Transverse::default(); 2] }
    }

    /// The wind at `t_s` for a vehicle that moves at `speed_m_s` at `altitude_m`. Advances the turbulence by a step.
    pub(super) fn step(
        &mut self,
        t_s: f64,
        speed_m_s: f64,
        altitude_m: f64,
        dt_s: f64,
        rng: &mut impl Rng,
    ) -> WindNow {
        let s = self.settings;
        let mean = Vector3::from(s.velocity_m_s);
        let along = if mean.norm() > 0.0 { mean.normalize() } else { Vector3::x() };
        let mut now = WindNow { even: mean, gust: None };
        match s.kind {
            WindKind::Constant => {}
            WindKind::Gust => {
                now.gust = Some(Gust {
                    along,
                    peak_m_s: s.gust_m_s,
                    length_s: s.gust_s,
                    period_s: s.gust_period_s.max(s.gust_s),
                    front_m_s: (mean.norm() + 0.5 * s.gust_m_s).max(SLOWEST_M_S),
                    t_s,
                });
            }
            WindKind::Dryden => {
                let even = Turbulence { std_m_s: [s.turbulence_m_s; 3], scale_m: [s.scale_m; 3] };
                now.even += self.turbulence(&even, &along, mean.norm() + speed_m_s, dt_s, rng);
            }
            WindKind::DrydenAltitude => {
                let near = low_altitude(altitude_m, mean.norm());
                now.even += self.turbulence(&near, &along, mean.norm() + speed_m_s, dt_s, rng);
            }
        }
        if s.on { now } else { WindNow::CALM }
    }

    /// Turbulence in the world, m/s, which passes with `air_m_s`: Dryden's forms, first order along the wind and second order across it.
    fn turbulence(
        &mut self,
        t: &Turbulence,
        along: &Vector3<f64>,
        air_m_s: f64,
        dt_s: f64,
        rng: &mut impl Rng,
    ) -> Vector3<f64> {
        let share = t.scale_m.map(|scale_m| dt_s * air_m_s.max(SLOWEST_M_S) / scale_m);
        let mut draw = || -> f64 { StandardNormal.sample(rng) };
        let decay = exp(-share[0]);
        self.along = self.along * decay + (1.0 - squared(decay)).sqrt() * draw();
        let [lateral, vertical] = &mut self.across;
        let values = [self.along, lateral.step(share[1], draw()), vertical.step(share[2], draw())];
        let horizontal = Vector3::new(along.x, along.y, 0.0);
        let x = horizontal.try_normalize(1e-9).unwrap_or_else(Vector3::x);
        let axes = [x, Vector3::z().cross(&x), Vector3::z()];
        (0..3).map(|i| axes[i] * (t.std_m_s[i] * values[i])).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    fn settings(kind: WindKind) -> WindSettings {
        WindSettings {
            on: true,
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
    fn a_gust_peaks_in_its_middle_ends_and_reaches_downwind_places_later() {
        let mut rng = Pcg64::seed_from_u64(1);
        let mut wind = Wind::new(&settings(WindKind::Gust));
        let mut at = |t_s: f64, x_m: f64| {
            wind.step(t_s, 0.0, 1.0, 1e-3, &mut rng).at(&Vector3::new(x_m, 0.0, 0.0)).x
        };
        assert!((at(1.0, 0.0) - 5.0).abs() < 1e-12);
        assert!((at(5.0, 0.0) - 2.0).abs() < 1e-12);
        // The front travels with the mean and half the gust, 3.5 m/s.
        assert!((at(1.0 + 0.7 / 3.5, 0.7) - 5.0).abs() < 1e-12);
        assert!(at(1.0, 0.7) < 5.0 - 0.1);
    }

    #[test]
    fn dryden_turbulence_has_the_asked_standard_deviation_along_every_axis() {
        let mut rng = Pcg64::seed_from_u64(1);
        let mut wind = Wind::new(&settings(WindKind::Dryden));
        let n = 400_000;
        let mean = Vector3::new(2.0, 0.0, 0.0);
        let sum = (0..n).fold(Vector3::zeros(), |sum: Vector3<f64>, i| {
            let now = wind.step(f64::from(i) * 0.01, 0.0, 1.0, 0.01, &mut rng).even - mean;
            sum + now.component_mul(&now)
        });
        for variance in (sum / f64::from(n)).iter() {
            // 4000 s at a time constant of 0.5 s: about 4000 independent samples, 5 % is over three standard errors.
            assert!((variance.sqrt() - 1.0).abs() < 0.05, "{variance}");
        }
    }

    #[test]
    fn turbulence_by_altitude_is_that_of_the_military_specification() {
        // At 100 ft in 10 m/s: sigma_w = 1, sigma_u = 1 / 0.2593^0.4, L_u = 100 ft / 0.2593^1.2, L_w = 100 ft.
        let t = low_altitude(30.48, 10.0);
        assert!((t.std_m_s[2] - 1.0).abs() < 1e-12);
        assert!((t.std_m_s[0] - 1.7160).abs() < 1e-3, "{t:?}");
        assert!((t.scale_m[0] - 154.03).abs() < 0.1, "{t:?}");
        assert!((t.scale_m[2] - 30.48).abs() < 1e-12);
        assert_eq!(low_altitude(1.0, 10.0), low_altitude(LOWEST_M, 10.0));
    }

    #[test]
    fn gusts_of_no_length_leave_the_mean() {
        let mut rng = Pcg64::seed_from_u64(1);
        let none = WindSettings { gust_s: 0.0, gust_period_s: 0.0, ..settings(WindKind::Gust) };
        let now = Wind::new(&none).step(1.0, 0.0, 1.0, 1e-3, &mut rng);
        assert!((now.at(&Vector3::zeros()) - Vector3::new(2.0, 0.0, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn wind_that_is_off_is_calm() {
        let mut rng = Pcg64::seed_from_u64(1);
        let mut wind = Wind::new(&WindSettings { on: false, ..settings(WindKind::Gust) });
        let now = wind.step(1.0, 0.0, 1.0, 1e-3, &mut rng);
        assert_eq!(now.at(&Vector3::zeros()), Vector3::zeros());
    }
}
