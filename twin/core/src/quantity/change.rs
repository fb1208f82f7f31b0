//! Quantities that change the world or the clock of a flight, set by a scenario, at a time of the flight, or by a client.

use super::Quantity;

/// Mass of the payload, in the world or in the gripper.
pub static PAYLOAD_MASS: Quantity = Quantity::new(
    "payload_mass",
    "kg",
    [0.001, 2.0],
    "mass of the payload",
    &["disturbances.kg", "task.least_payload_kg"],
)
.or_none_at(&["payload.mass_kg"])
.step(0.01)
.sent_as(&["disturb.payload_mass.kg"]);

/// Wind speed in the world: mean, gusts and turbulence.
pub static WIND: Quantity = Quantity::new(
    "wind",
    "m/s",
    [-30.0, 30.0],
    "velocity of the air along an axis",
    &["wind.*_m_s", "disturbances.velocity_m_s", "faults.velocity_m_s"],
)
.step(0.5)
.sent_as(&["disturb.wind.velocity_m_s"]);

/// A push on the base.
pub static PUSH_FORCE: Quantity = Quantity::new(
    "push_force",
    "N",
    [-100.0, 100.0],
    "force of a push along an axis",
    &["disturbances.force_n"],
)
.step(0.5)
.sent_as(&["disturb.push.force_n"]);

/// How long a push lasts.
pub static PUSH_DURATION: Quantity = Quantity::new(
    "push_duration",
    "s",
    [0.0, 10.0],
    "how long a push lasts",
    &["disturbances.duration_s"],
)
.step(0.05)
.sent_as(&["disturb.push.duration_s"]);

/// Number of ticks of one `step`.
pub static STEP_TICKS: Quantity =
    Quantity::new("step_ticks", "ticks", [1.0, 1000.0], "ticks that a paused flight flies", &[])
        .step(1.0)
        .sent_as(&["step.ticks"]);

/// Speed of the flight's clock.
pub static SPEED: Quantity =
    Quantity::new("speed", "× real time", [0.01, 100.0], "simulated seconds per second", &[])
        .step(0.01)
        .sent_as(&["speed.value"]);

/// Largest whole number that a double represents exactly; JSON would change a larger seed.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// Seed of everything random: of a scenario, of the command line, or of a restart.
pub static SEED: Quantity = Quantity::new(
    "seed",
    "",
    [0.0, MAX_EXACT],
    "start of everything random",
    &["seed", "predictor.seed", "sweep.seed"],
)
.step(1.0)
.sent_as(&["restart.seed"]);

/// Time of a recording to go to.
pub static SEEK_TIME: Quantity =
    Quantity::new("seek_time", "s", [0.0, 1e6], "time of a recording to go to", &[])
        .step(0.01)
        .sent_as(&["seek.t_s"]);

/// All quantities of this file.
pub(super) static ALL: [&Quantity; 8] =
    [&PAYLOAD_MASS, &WIND, &PUSH_FORCE, &PUSH_DURATION, &STEP_TICKS, &SPEED, &SEED, &SEEK_TIME];
