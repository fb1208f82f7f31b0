//! Gains, which an operator changes while flying. [`crate::tuning`] says which field each of them sets.

use super::Quantity;

/// Error slope of a coordinate.
pub static SLOPE: Quantity = Quantity::new(
    "slope",
    "1/s",
    [0.0, 20.0],
    "pull of the error in s = ė + Φe",
    &["gains.slope.*"],
)
.step(0.05);

/// Damping of x y z, whose sliding variable is a velocity.
pub static DAMPING_OF_TRANSLATION: Quantity = Quantity::new(
    "damping_of_translation",
    "N s/m",
    [0.0, 60.0],
    "force per sliding variable",
    &["gains.damping.x", "gains.damping.y", "gains.damping.z"],
)
.step(0.05);

/// Damping of attitude and joints, whose sliding variable is an angular rate.
pub static DAMPING_OF_ROTATION: Quantity = Quantity::new(
    "damping_of_rotation",
    "N m s/rad",
    [0.0, 60.0],
    "moment per sliding variable",
    &["gains.damping.*"],
)
.step(0.05);

/// Lead of the compensation.
pub static LEAD: Quantity = Quantity::new(
    "lead",
    "",
    [0.0, 2.0],
    "share of the loop's delay by which the compensation looks ahead; 0 is the paper's",
    &["gains.lead.*"],
)
.step(0.05);

/// Leak of the adaptive gain.
pub static LEAK: Quantity =
    Quantity::new("leak", "1/s", [0.1, 20.0], "leak of the adaptive gain σ̂", &["gains.leak"])
        .step(0.05);

/// Adaptive gain at the start.
pub static ROBUST_GAIN_INITIAL: Quantity = Quantity::new(
    "robust_gain_initial",
    "",
    [0.001, 10.0],
    "adaptive gain at the start; a change sets σ̂ now",
    &["gains.robust_gain_initial"],
)
.step(0.01);

/// Cap of the adaptive gain.
pub static ROBUST_GAIN_CAP: Quantity = Quantity::new(
    "robust_gain_cap",
    "",
    [0.05, 1e6],
    "largest adaptive gain",
    &["gains.robust_gain_cap"],
)
.step(0.05);

/// Norm of the sliding variable below which the robust term is linear.
pub static BOUNDARY_LAYER: Quantity = Quantity::new(
    "boundary_layer",
    "",
    [1e-6, 5.0],
    "‖s‖ below which the robust term is linear",
    &["gains.boundary_layer"],
)
.step(0.01);

/// The low-pass on `r_hat` is in force.
pub static RESIDUAL_FILTER_ON: Quantity = Quantity::new(
    "residual_filter_on",
    "",
    [0.0, 1.0],
    "1: r̂ passes the low-pass, 0: r̂ is taken as it is",
    &["gains.residual_filter_on"],
)
.step(1.0);

/// Corner of the low-pass on `r_hat`. At most 50 Hz: a period of 10 ms cannot represent more.
pub static RESIDUAL_BANDWIDTH: Quantity = Quantity::new(
    "residual_bandwidth_hz",
    "Hz",
    [0.1, 50.0],
    "corner of the low-pass on r̂",
    &["gains.residual_bandwidth_hz"],
)
.step(0.1);

/// Forgetting factor.
pub static FORGETTING: Quantity = Quantity::new(
    "forgetting",
    "",
    [0.9, 1.0],
    "forgetting factor of the RLS step",
    &["gains.forgetting"],
)
.step(0.0005);

/// Time constant of the adapter's bias.
pub static BIAS: Quantity = Quantity::new(
    "bias_s",
    "s",
    [0.0, 60.0],
    "time constant of the adapter's bias; 0: no bias",
    &["gains.bias_s"],
)
.step(0.05);

/// Leak of the adapter's weights.
pub static WEIGHT_LEAK: Quantity = Quantity::new(
    "weight_leak_per_s",
    "1/s",
    [0.0, 20.0],
    "leak of the adapter's weights to zero",
    &["gains.weight_leak_per_s"],
)
.step(0.05);

/// Memory of the correction of the whole horizon.
pub static HORIZON_MEMORY: Quantity = Quantity::new(
    "horizon_memory_s",
    "s",
    [0.0, 600.0],
    "memory of the correction of the whole horizon; 0: no such correction",
    &["gains.horizon_memory_s"],
)
.step(1.0);

/// Covariance after a reset.
pub static RESET_SCALE: Quantity = Quantity::new(
    "reset_scale",
    "",
    [0.001, 100.0],
    "covariance after a reset is σ₀ I",
    &["gains.reset_scale"],
)
.step(0.01);

/// Threshold of the reset.
pub static RESET_THRESHOLD: Quantity = Quantity::new(
    "reset_threshold",
    "",
    [0.01, 1000.0],
    "mean innovation at which the covariance is reset",
    &["gains.reset_threshold"],
)
.step(0.01);

/// Smoothing of the mean innovation.
pub static INNOVATION_SMOOTHING: Quantity = Quantity::new(
    "innovation_smoothing",
    "",
    [0.0, 0.999],
    "weight of the old value in the mean innovation",
    &["gains.innovation_smoothing"],
)
.step(0.001);

/// The reset is in force.
pub static RESET_ON: Quantity = Quantity::new(
    "reset_on",
    "",
    [0.0, 1.0],
    "1: the covariance may be reset, 0: never",
    &["gains.reset_on"],
)
.step(1.0);

/// The adapter is in force.
pub static ADAPTER_ON: Quantity = Quantity::new(
    "adapter_on",
    "",
    [0.0, 1.0],
    "1: adapts, 0: base forecast only",
    &["gains.adapter_on"],
)
.step(1.0);

/// All quantities of this file.
pub(super) static ALL: [&Quantity; 19] = [
    &SLOPE,
    &DAMPING_OF_TRANSLATION,
    &DAMPING_OF_ROTATION,
    &LEAD,
    &LEAK,
    &ROBUST_GAIN_INITIAL,
    &ROBUST_GAIN_CAP,
    &BOUNDARY_LAYER,
    &RESIDUAL_FILTER_ON,
    &RESIDUAL_BANDWIDTH,
    &FORGETTING,
    &BIAS,
    &WEIGHT_LEAK,
    &HORIZON_MEMORY,
    &RESET_SCALE,
    &RESET_THRESHOLD,
    &INNOVATION_SMOOTHING,
    &RESET_ON,
    &ADAPTER_ON,
];
