//! Synthetic telemetry for the tests of the server.

use std::ops::Range;
use std::sync::Arc;

use crate::server::protocol::ChannelInfo;
use crate::server::telemetry::{Picture, Telemetry};

/// A channel called `name`; tests use no other field.
pub(super) fn channel(name: &str) -> ChannelInfo {
    ChannelInfo {
        name: name.to_owned(),
        label: String::new(),
        group: String::new(),
        unit: String::new(),
        row: None,
        limits: None,
        z_scale: None,
        weight: None,
    }
}

/// Telemetry of these ticks with the given rows and without bodies to draw.
pub(in crate::server) fn flown(ticks: Range<u64>, row: impl Fn(u64) -> Vec<f32>) -> Telemetry {
    let picture = Picture {
        t_s: 0.0,
        poses: Vec::new(),
        ghost: [0.0; 7],
        contacts: Vec::new(),
        spectrum: Vec::new(),
    };
    Telemetry {
        schema_id: 1,
        first_tick: ticks.start,
        rows: ticks.map(|tick| Arc::from(row(tick))).collect(),
        gap: 0,
        reset: false,
        picture: Arc::new(picture),
    }
}
