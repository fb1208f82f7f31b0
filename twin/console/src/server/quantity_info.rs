//! Quantities of the world that a client may set, with the data for their sliders.

use serde::Serialize;
use ts_rs::TS;

use twin_core::quantity;

/// A number that messages of a client carry, with what bounds it.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct QuantityInfo {
    /// Unique name, `payload_mass`.
    pub name: String,
    /// Unit, empty if none.
    pub unit: String,
    /// What it says, in a few words.
    pub help: String,
    /// Smallest allowed value.
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
    /// Step of a slider.
    pub step: f64,
    /// The messages that carry it: type, kind of a disturbance, field.
    pub messages: Vec<String>,
}

/// Every quantity that messages of a client carry, except the gains, which have a list of their own.
pub(super) fn list() -> Vec<QuantityInfo> {
    let sent = quantity::all().filter(|quantity| !quantity.messages.is_empty());
    sent.map(|quantity| QuantityInfo {
        name: quantity.name.to_owned(),
        unit: quantity.unit.to_owned(),
        help: quantity.help.to_owned(),
        min: quantity.min,
        max: quantity.max,
        step: quantity.step,
        messages: quantity.messages.iter().map(|message| (*message).to_owned()).collect(),
    })
    .collect()
}
