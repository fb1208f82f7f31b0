//! The sizes of a network as the head of a file states them, and the checks that every network shares.

use serde::de::DeserializeOwned;

use super::{Head, WeightsError};

/// The configuration in `head`.
///
/// # Errors
/// [`WeightsError::Head`] if it is not one of this network.
pub(in crate::residual) fn read<T: DeserializeOwned>(head: &Head) -> Result<T, WeightsError> {
    serde_json::from_value(head.config.clone())
        .map_err(|error| WeightsError::Head { reason: format!("config: {error}") })
}

/// The network has as many input channels and rows of the residual as `head` names.
///
/// # Errors
/// [`WeightsError::Config`] if not.
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

/// Each size, by its key, is from 1 to the most that is allowed.
///
/// # Errors
/// [`WeightsError::Config`] naming the first that is not.
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

/// The width of a token is shared evenly by the attention heads.
///
/// # Errors
/// [`WeightsError::Config`] if not.
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
