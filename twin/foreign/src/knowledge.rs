//! Where the residual of a recording is known: the stretches in which the twin predicts and adapts, and those in which it waits.
//!
//! In: a playback. Out: [`Knowledge`] in order of time.

use std::sync::Arc;

use super::playback::{Cursor, Playback};

/// Texts of the events when the residual becomes known and when it becomes unknown.
const MIRRORED: &str = "in the air: residual known, the twin predicts and adapts in shadow";
const UNKNOWN: &str = "on the ground, or force or motion unknown: the adapter is frozen";

/// Stretch of a recording in which the residual is known in some coordinate, or in none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Knowledge {
    /// Its first tick.
    pub first: usize,
    /// Whether the residual is known.
    pub known: bool,
}

impl Knowledge {
    /// One sentence for people.
    pub const fn text(self) -> &'static str {
        if self.known { MIRRORED } else { UNKNOWN }
    }
}

/// The stretches of a recording, from the knowledge of its residual at each tick.
pub(super) fn knowledge(playback: &Arc<Playback>) -> Vec<Knowledge> {
    let mut cursor = Cursor::new(playback);
    let mut stretches: Vec<Knowledge> = Vec::new();
    for first in 0..playback.ticks() {
        let known = cursor.frame(first).is_some_and(|m| m.residual_known().contains(&true));
        if stretches.last().is_none_or(|last| last.known != known) {
            stretches.push(Knowledge { first, known });
        }
    }
    stretches
}
