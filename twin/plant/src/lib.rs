//! The simulated vehicle in its arena: the only place that knows Rapier and glam.
//!
//! In: a [`twin_core::tick::Setpoint`] and the inner controllers. Out: a [`twin_core::tick::Measurement`] every 10 ms, which is ten
//! steps of 1 ms.
//! State: Rapier's world, actuators, wake, wind, sensors, estimator.

pub mod model;
pub mod settings;
mod convert;
mod lump;
pub mod articulation;
mod velocities;
mod coriolis;
mod leapfrog;
mod arena;
mod gripper;
mod command_link;
mod mismatch;
mod battery;
mod rotors;
mod wind;
mod inflow;
mod aero;
mod ground;
mod wake;
mod propulsion;
mod servo;
mod sensors;
mod estimator;
mod setup;
mod world;
mod budget;
pub mod vehicle;
mod failures;
mod truth;
mod source;
mod free;
pub mod curves;
#[cfg(test)]
mod fixture;

pub use articulation::Articulation;
pub use free::{FreeBody, Motion, Wrench, locked};
pub use settings::{
    AeroSettings, ArenaObject, ArenaSettings, BatterySettings, ContactSettings, GripperSettings,
    LinkSettings, MismatchSettings, PayloadSettings, PlantSettings, RotorSettings, SensorSettings,
    ServoSettings, VehicleSettings, WindKind, WindSettings,
};
pub use setup::{Start, new_world};
pub use vehicle::SimulatedVehicle;

/// Plant step, s.
const STEP_S: f64 = 1e-3;

/// Steps in a tick of 10 ms.
const STEPS_PER_TICK: u64 = 10;

/// Why a vehicle or an arena cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum PlantError {
    /// A name in the scenario does not exist in the URDF.
    #[error("{key}: {file} has no {what} called {name:?}; it has {available}")]
    UnknownName {
        /// Scenario key.
        key: &'static str,
        /// URDF file.
        file: String,
        /// `link` or `joint`.
        what: &'static str,
        /// Name that the scenario gives.
        name: String,
        /// Names that the URDF has.
        available: String,
    },
    /// The physics engine stores an inertia tensor that differs from the URDF's.
    #[error(
        "link {link:?}: Rapier cannot represent its inertia tensor (relative error {relative_error:.1e}); make the \
         principal moments of this small link equal or separate them by more than 1e-5 kg m²"
    )]
    Inertia {
        /// Link.
        link: String,
        /// Relative error of the tensor.
        relative_error: f64,
    },
    /// A mesh has no convex hull, so it cannot collide.
    #[error(
        "link {link:?}: its collision mesh has no convex hull (fewer than four points that are not in a plane)"
    )]
    Hull {
        /// Link.
        link: String,
    },
    /// The vehicle has more moving joints than can be simulated.
    #[error("the vehicle: {0}")]
    TooMuch(#[from] twin_input::Excess),
    /// A joint could not be inserted.
    #[error("joint {joint:?} would close a kinematic loop; a floating-base tree is required")]
    Loop {
        /// Joint.
        joint: String,
    },
    /// The number of rotors is outside the range that the allocation can use.
    #[error("vehicle.rotors: {found} rotors given, 3 to {max} needed")]
    Rotors {
        /// Number of rotors that the scenario gives.
        found: usize,
        /// Largest number of rotors.
        max: usize,
    },
    /// A model file cannot be used.
    #[error(transparent)]
    Model(#[from] crate::model::ModelError),
}
