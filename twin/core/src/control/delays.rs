//! The delays of the loop, from which the lead of the compensation follows.
//!
//! A residual is measured late (filter `H`), its estimate is filtered (low-pass on `r_hat`), and the force that answers it comes late: along
//! z the rotors must change their speed, along x and y the vehicle must tilt first (command filter), and a joint waits for its servo. A
//! filter's delay is its group delay at frequency zero, which is the delay of every slow signal.

use std::f64::consts::{PI, SQRT_2};

use super::Gains;
use super::attitude::COMMAND_FILTER_DELAY_S;
use crate::notation::Coords;

/// Corner of the filter pair `H` on acceleration and applied force, Hz: the optimum between noise and lag.
pub const RESIDUAL_CORNER_HZ: f64 = 8.0;

/// Delays of a vehicle, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoopDelays {
    /// From a command to the rotors' thrust: transport, and the rotors' lag.
    pub rotors_s: f64,
    /// From a command to the joints' torque.
    pub joints_s: f64,
}

impl LoopDelays {
    /// Delay between a change of the residual and the force that answers it, per coordinate, s.
    pub fn of_residual(&self, gains: &Gains) -> Coords {
        // 2nd-order Butterworth: sqrt(2) / w
        let label_s = SQRT_2 / (2.0 * PI * RESIDUAL_CORNER_HZ);
        let low_pass_s = if gains.residual_filter_on {
            (2.0 * PI * gains.residual_bandwidth_hz).recip()
        } else {
            0.0
        };
        let known_s = label_s + low_pass_s;
        let (tilted, direct) =
            (known_s + COMMAND_FILTER_DELAY_S + self.rotors_s, known_s + self.rotors_s);
        let joint = known_s + self.joints_s;
        Coords::from([tilted, tilted, direct, direct, direct, direct, joint, joint])
    }

    /// Lead of the compensation per coordinate, s: the share of the delay that [`Gains::lead`] asks for.
    pub fn lead(&self, gains: &Gains) -> Coords {
        self.of_residual(gains).component_mul(&gains.lead)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Preset;
    use crate::control::attitude::CommandFilter;
    use crate::filter::{Butterworth, LowPass};
    use nalgebra::Vector1;

    /// A ramp is sampled, so a delay is found to a part of a sample of 1 ms.
    const SAMPLE_S: f64 = 1e-3;

    /// How late `step` follows a ramp of slope 1, s.
    fn late(mut step: impl FnMut(f64) -> f64) -> f64 {
        let mut t_s = 0.0;
        let mut behind = 0.0;
        for _ in 0..5000 {
            t_s += SAMPLE_S;
            behind = t_s - step(t_s);
        }
        behind
    }

    #[test]
    fn the_delays_of_the_filters_are_those_with_which_they_follow_a_ramp() {
        let gains = Gains::preset(Preset::Paper);
        let delays = LoopDelays { rotors_s: 0.045, joints_s: 0.002 }.of_residual(&gains);
        let mut label = Butterworth::<1>::new(RESIDUAL_CORNER_HZ, SAMPLE_S);
        let mut low_pass = LowPass::<1>::new();
        let filtered = late(|t| label.step(&Vector1::new(t)).x)
            + late(|t| low_pass.step(&Vector1::new(t), gains.residual_bandwidth_hz, SAMPLE_S).x);
        let mut command = CommandFilter::default();
        let tilted = late(|t| {
            command.step((t, 0.0), [0.0; 3], SAMPLE_S);
            command.eta.x
        });
        for (row, wanted) in
            [(0, filtered + tilted + 0.045), (2, filtered + 0.045), (7, filtered + 0.002)]
        {
            assert!(
                (delays[row] - wanted).abs() < 2.0 * SAMPLE_S,
                "{row}: {} {wanted}",
                delays[row]
            );
        }
    }

    #[test]
    fn the_lead_is_the_share_of_the_delay_that_is_asked_for_and_none_for_the_paper() {
        let delays = LoopDelays { rotors_s: 0.045, joints_s: 0.0 };
        let mut gains = Gains::preset(Preset::Paper);
        assert_eq!(delays.lead(&gains), Coords::zeros());
        gains.lead[0] = 0.5;
        assert!(
            (delays.lead(&gains)[0] - 0.5 * delays.of_residual(&gains)[0]).abs() < f64::EPSILON
        );
        gains.residual_filter_on = false;
        // 1 / (2 pi 5 Hz) = 31.8 ms, half of it
        assert!(
            (0.5 * delays.of_residual(&Gains::preset(Preset::Paper))[0]
                - delays.lead(&gains)[0]
                - 0.0159)
                .abs()
                < 1e-4
        );
    }
}
