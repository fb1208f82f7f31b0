//! How the true vehicle differs from the one that the loop assumes. The seed of the flight decides it.

use nalgebra::Vector2;
use rand::SeedableRng;
use rand::distr::Distribution;
use rand_pcg::Pcg64;

use super::settings::MismatchSettings;
use twin_core::normal::StandardNormal;
use twin_core::notation::{MAX_ROTORS, PerRotor};

/// Separates this stream of random numbers from those of wind and sensors.
const STREAM: u64 = 0x0dd_ba11;

/// Largest difference in standard deviations. A part that differs more is rejected before it is mounted.
const LARGEST: f64 = 2.5;

/// True values per assumed values; all are 1 for a vehicle that is as assumed.
#[derive(Clone, Debug)]
pub(super) struct Mismatch {
    drawn: Ratios,
    settings: MismatchSettings,
}

/// Ratios of true to assumed values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ratios {
    /// Thrust of each rotor at a given speed.
    pub(super) rotor_thrust: PerRotor,
    /// Time constants of each rotor.
    pub(super) rotor_lag: PerRotor,
    /// Torque of each joint at a given command.
    pub(super) joint_torque: Vector2<f64>,
}

impl Ratios {
    const EQUAL: Self = Self {
        rotor_thrust: [1.0; MAX_ROTORS],
        rotor_lag: [1.0; MAX_ROTORS],
        joint_torque: Vector2::new(1.0, 1.0),
    };
}

impl Mismatch {
    /// The differences that `seed` gives.
    pub(super) fn new(settings: &MismatchSettings, seed: u64) -> Self {
        let mut rng = Pcg64::seed_from_u64(seed ^ STREAM);
        let mut ratio = |std: f64| {
            let n: f64 = StandardNormal.sample(&mut rng);
            1.0 + std * n.clamp(-LARGEST, LARGEST)
        };
        let drawn = Ratios {
            rotor_thrust: std::array::from_fn(|_| ratio(settings.rotor_thrust)),
            rotor_lag: std::array::from_fn(|_| ratio(settings.rotor_lag)),
            joint_torque: Vector2::from_fn(|_, _| ratio(settings.joint_torque)),
        };
        Self { drawn, settings: *settings }
    }

    /// The ratios in force.
    pub(super) fn ratios(&self) -> Ratios {
        if self.settings.on { self.drawn } else { Ratios::EQUAL }
    }

    /// Switches all differences.
    pub(super) fn switch(&mut self, on: bool) {
        self.settings.on = on;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_give_different_vehicles_within_limits_and_a_switch_gives_the_assumed_one() {
        let settings =
            MismatchSettings { on: true, rotor_thrust: 0.02, rotor_lag: 0.05, joint_torque: 0.03 };
        let all: Vec<Ratios> =
            (0..200).map(|seed| Mismatch::new(&settings, seed).ratios()).collect();
        assert_ne!(all[0], all[1]);
        let thrusts: Vec<f64> = all.iter().flat_map(|ratios| ratios.rotor_thrust).collect();
        let n = thrusts.len() as f64;
        let mean = thrusts.iter().sum::<f64>() / n;
        let std = (thrusts.iter().map(|t| (t - mean) * (t - mean)).sum::<f64>() / n).sqrt();
        // Three standard errors of mean and standard deviation of 1600 draws; the limit takes 2 % from the latter.
        assert!((mean - 1.0).abs() < 3.0 * 0.02 / n.sqrt(), "{mean}");
        assert!((std / 0.02 - 0.98).abs() < 0.06, "{std}");
        assert!(thrusts.iter().all(|t| (t - 1.0).abs() <= 0.05 + 1e-12));
        let mut assumed = Mismatch::new(&settings, 1);
        assumed.switch(false);
        assert_eq!(assumed.ratios(), Ratios::EQUAL);
    }
}
