//! The sizes of a network from the head of its file, and the checks that all networks share.

use serde::de::DeserializeOwned;

use super::{Head, WeightsError};

/// The configuration in `head`.
///
/// # Errors
/// [`WeightsError::Head`] if the head has no configuration of this network.
pub(in crate::residual) fn read<T: DeserializeOwned>(head: &Head) -> Result<T, WeightsError> {
    serde_json::from_value(head.config.clone())
        .map_err(|error| WeightsError::Head { reason: format!("config: {error}") })
}

/// Checks that the network has as many input channels and residual coordinates as `head` names.
///
/// # Errors
/// [`WeightsError::Config`] if the numbers differ.
pub(in crate::residual) fn fit(
    head: &Head,
    channels: usize,
    outputs: usize,
) -> Result<(), WeightsError> {
    for (key, found, expected) in [
        ("channels", channels, head.channel_names.len()),
        ("outputs", outputs, head.output_names.len()),
    ] {
        if found != expected {
            let expected = format!("{expected}, as many as the head names");
            return Err(WeightsError::Config { key, found: found.to_string(), expected });
        }
    }
    Ok(())
}

/// Checks that each size, given with its key, is between 1 and its maximum.
///
/// # Errors
/// [`WeightsError::Config`] that names the first wrong size.
pub(in crate::residual) fn within(
    sizes: &[(&'static str, usize, usize)],
) -> Result<(), WeightsError> {
    for (key, found, most) in sizes {
        if !(1..=*most).contains(found) {
            let expected = format!("1..={most}");
            return Err(WeightsError::Config { key, found: found.to_string(), expected });
        }
    }
    Ok(())
}

/// Checks that a size has the only value that its network allows.
///
/// # Errors
/// [`WeightsError::Config`] if it has another one.
pub(in crate::residual) fn exactly(
    key: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), WeightsError> {
    if found == expected {
        return Ok(());
    }
    Err(WeightsError::Config { key, found: found.to_string(), expected: expected.to_string() })
}

/// Checks that the number of attention heads divides the width of a token.
///
/// # Errors
/// [`WeightsError::Config`] if it does not.
pub(in crate::residual) fn heads_divide(heads: usize, d_model: usize) -> Result<(), WeightsError> {
    if d_model.is_multiple_of(heads) {
        return Ok(());
    }
    Err(WeightsError::Config {
        key: "heads",
        found: heads.to_string(),
        expected: format!("a divisor of d_model = {d_model}"),
    })
}
