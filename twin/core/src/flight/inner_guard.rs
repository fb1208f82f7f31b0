//! Between the source and the inner controller: passes finite states and finite commands only, and remembers the last command.

use crate::control::InnerController;
use crate::source::{InnerLoop, InnerState};
use crate::tick::{ActuatorCommand, Setpoint};

/// The inner controller during one tick.
pub(super) struct InnerGuard<'a> {
    inner: &'a mut InnerController,
    last: ActuatorCommand,
    all_finite: bool,
}

impl<'a> InnerGuard<'a> {
    /// A guard of `inner`, whose last command was `last`.
    pub(super) fn new(inner: &'a mut InnerController, last: ActuatorCommand) -> Self {
        Self { inner, last, all_finite: true }
    }

    /// The last finite command.
    pub(super) fn last(&self) -> ActuatorCommand {
        self.last
    }

    /// True if every state and every command of this tick was finite.
    pub(super) fn all_finite(&self) -> bool {
        self.all_finite
    }
}

impl InnerLoop for InnerGuard<'_> {
    /// The command for this state; the last one if the state or the command is not finite.
    fn command(&mut self, setpoint: &Setpoint, state: &InnerState) -> ActuatorCommand {
        let command = state.is_finite().then(|| self.inner.command(setpoint, state));
        match command.filter(ActuatorCommand::is_finite) {
            Some(command) => self.last = command,
            None => self.all_finite = false,
        }
        self.last
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Vector2, Vector3};

    use super::*;
    use crate::control::{Allocation, Rotor};
    use crate::fixture;

    /// A controller for a symmetric quadrotor with 0 to 10 N per rotor.
    fn controller() -> InnerController {
        let rotor = |(x, y, spin): (f64, f64, f64)| Rotor {
            position_in_body: Vector3::new(x, y, 0.0),
            torque_per_thrust_m: 0.02 * spin,
        };
        let rotors = [(0.2, 0.2, 1.0), (-0.2, 0.2, -1.0), (-0.2, -0.2, 1.0), (0.2, -0.2, -1.0)];
        let allocation = Allocation::new(&rotors.map(rotor), 0.0, 10.0);
        InnerController::new(allocation, Vector3::repeat(0.1), Vector2::repeat(1.0), 0.5, 0.002)
    }

    #[test]
    fn a_state_that_is_not_finite_leaves_the_last_command_in_force() {
        let setpoint = fixture::tick(0).setpoint;
        let level = InnerState {
            eta: Vector3::zeros(),
            eta_dot: Vector3::zeros(),
            joint: Vector2::zeros(),
            joint_dot: Vector2::zeros(),
        };
        let mut inner = controller();
        let mut guard = InnerGuard::new(&mut inner, fixture::tick(0).actuators);
        let good = guard.command(&setpoint, &level);
        assert!(good.is_finite() && guard.all_finite());
        for bad in [
            InnerState { eta: Vector3::new(0.0, f64::NAN, 0.0), ..level },
            InnerState { eta_dot: Vector3::repeat(f64::INFINITY), ..level },
            InnerState { joint: Vector2::repeat(f64::NAN), ..level },
            // Finite, but the command overflows.
            InnerState {
                joint_dot: Vector2::repeat(f64::MAX),
                eta_dot: Vector3::repeat(f64::MAX),
                ..level
            },
        ] {
            let mut inner = controller();
            let mut guard = InnerGuard::new(&mut inner, good);
            assert_eq!(guard.command(&setpoint, &bad), good, "{bad:?}");
            assert!(!guard.all_finite());
        }
    }
}
