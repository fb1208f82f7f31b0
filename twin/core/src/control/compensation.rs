//! Limits `r_hat` between the adapter and the control law: bounds or freezes it in contact, clips it and low-passes it.
//!
//! In contact the adapter is frozen and `r_hat` of x y z is constant. Attitude and joints then follow the measured residual (time-delay
//! control): a constant `r_hat` would leave a tilt there that pushes the opened hand into the cube.
//!
//! State: the low-pass, and the value of `r_hat` when bounding or freezing began.

use crate::filter::LowPass;
use crate::notation::{Coords, N};
use crate::tick::{Adaptation, Reference};

use super::Gains;

/// Limits the residual estimate before the control law uses it.
#[derive(Clone, Debug, Default)]
pub struct Compensation {
    low_pass: LowPass<N>,
    centre: Option<Coords>,
    output: Coords,
}

impl Compensation {
    /// `r_hat` in force for this tick, N and N m, from the adapted `r_hat` and the measured `residual`.
    pub fn step(
        &mut self,
        r_hat: &Coords,
        residual: &Coords,
        nominal_gravity: &Coords,
        reference: &Reference,
        gains: &Gains,
        dt_s: f64,
    ) -> Coords {
        let input = match (reference.adaptation, reference.release) {
            (_, Some(known)) => hold_translation(self.centre.insert(known), residual),
            (Adaptation::Free, None) => {
                self.centre = None;
                *r_hat
            }
            (Adaptation::Bounded, None) => {
                let centre = *self.centre.get_or_insert(self.output);
                gains.safe_set.bound_residual(r_hat, &centre)
            }
            (Adaptation::Held, None) => {
                hold_translation(self.centre.get_or_insert(self.output), residual)
            }
        };
        let input =
            if gains.clips { gains.safe_set.clip_residual(&input, nominal_gravity) } else { input };
        self.output = if gains.residual_filter_on {
            if let Some(known) = &reference.release {
                // The residual after a release is known, so the low-pass jumps to it.
                self.low_pass.jump(&hold_translation(known, &self.output));
            }
            self.low_pass.step(&input, gains.residual_bandwidth_hz, dt_s)
        } else {
            self.low_pass.reset();
            input
        };
        self.output
    }
}

/// x y z from `held`, all other coordinates from `live`.
fn hold_translation(held: &Coords, live: &Coords) -> Coords {
    Coords::from_fn(|row, _| if row < 3 { held[row] } else { live[row] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Preset;
    use crate::tick::GripperCommand;

    fn reference(adaptation: Adaptation) -> Reference {
        let zero = Coords::zeros();
        Reference {
            chi_des: zero.into(),
            chi_des_dot: zero.into(),
            chi_des_ddot: zero,
            gripper: GripperCommand::Open,
            adaptation,
            follows_measurement: false,
            transporting: false,
            cruising: false,
            release: None,
        }
    }

    #[test]
    fn held_translation_ignores_adapter_and_measurement_and_takes_a_known_jump() {
        let gains = Gains::preset(Preset::Tuned);
        let gravity = Coords::zeros();
        let (live, wild) = (Coords::repeat(0.4), Coords::repeat(0.1));
        let mut c = Compensation::default();
        let before = c.step(
            &Coords::repeat(0.5),
            &live,
            &gravity,
            &reference(Adaptation::Free),
            &gains,
            0.01,
        );
        let held = c.step(&wild, &live, &gravity, &reference(Adaptation::Held), &gains, 0.01);
        assert_eq!(before.fixed_rows::<3>(0), held.fixed_rows::<3>(0));
        assert!(
            held[4] < before[4] && held[4] > live[4],
            "attitude rows follow the measured residual"
        );
        let jump = Reference { release: Some(Coords::repeat(0.3)), ..reference(Adaptation::Held) };
        for reference in [jump, reference(Adaptation::Held)] {
            let released = c.step(&wild, &live, &gravity, &reference, &gains, 0.01);
            assert!(
                (released.fixed_rows::<3>(0) - Coords::repeat(0.3).fixed_rows::<3>(0)).norm()
                    < 1e-12
            );
        }
    }

    #[test]
    fn bounded_compensation_stays_in_its_window() {
        let gains =
            Gains { clips: false, residual_filter_on: false, ..Gains::preset(Preset::Tuned) };
        let mut c = Compensation::default();
        c.step(
            &Coords::zeros(),
            &Coords::zeros(),
            &Coords::zeros(),
            &reference(Adaptation::Free),
            &gains,
            0.01,
        );
        let far = Coords::repeat(100.0);
        let out =
            c.step(&far, &far, &Coords::zeros(), &reference(Adaptation::Bounded), &gains, 0.01);
        assert_eq!(out, Coords::from(gains.safe_set.residual_window));
    }
}
