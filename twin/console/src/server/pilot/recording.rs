//! Moves through a mirrored flight. The next tick of a live flight may not have arrived, and its stream may start anew.

use std::sync::Arc;

use super::{Pilot, ServedFlight};
use crate::server::mirrored::Mirrored;
use crate::server::protocol::NoticeLevel;

/// If the shadow is this many ticks ahead of the live flight, the clock of the vehicle was set back.
const FAR_AHEAD_TICKS: u64 = 100;

impl Pilot {
    /// Whether the flight is live and its next tick has not arrived.
    pub(super) fn is_ahead(&self) -> bool {
        let live = self.served.mirrored.as_ref().filter(|mirrored| mirrored.is_live());
        live.is_some_and(|live| self.served.next_tick >= live.shadow.ticks() as u64)
    }

    /// Publishes the news of a live flight; goes to its newest tick if its stream started anew or its clock was set back.
    pub(super) fn attend(&mut self) {
        let Some(mirrored) = self.served.mirrored.clone().filter(|mirrored| mirrored.is_live())
        else {
            return;
        };
        for text in mirrored.news() {
            if mirrored.is_lost() {
                self.alarm(&text);
            } else {
                tracing::info!("{text}");
                self.hub.notice(None, NoticeLevel::Info, &text);
            }
        }
        let edge = mirrored.shadow.ticks() as u64;
        if let Some(renewed) = mirrored.renewed() {
            self.go_to(&Arc::new(renewed), f64::MAX, None);
        } else if edge > 0 && self.served.next_tick > edge + FAR_AHEAD_TICKS {
            self.go_to(&mirrored, f64::MAX, None);
        }
    }

    /// Whether the last tick of a recording is flown; a live flight has no last tick.
    pub(super) fn is_at_end(&self) -> bool {
        let ended = self.served.mirrored.as_ref().filter(|mirrored| !mirrored.is_live());
        let ticks = ended.map(|mirrored| mirrored.shadow.ticks() as u64);
        ticks.is_some_and(|ticks| self.served.next_tick >= ticks)
    }

    /// Goes to the time `t_s` of the recording, s; the gains in force stay. `client` gets the notice if the seek is refused.
    pub(super) fn seek(&mut self, t_s: f64, client: Option<u64>) {
        if let Some(mirrored) = self.served.mirrored.clone() {
            // Gains that were set before the seek stay in force after it.
            self.apply_changes();
            self.go_to(&mirrored, t_s, client);
        }
    }

    fn go_to(&mut self, mirrored: &Arc<Mirrored>, t_s: f64, client: Option<u64>) {
        let (first, warm_up) = mirrored.run_up(t_s);
        let mut tuning = *self.served.flight.tuning();
        // A stream that started anew may belong to a vehicle with another mass.
        tuning.gains.nominal_inertia = mirrored.shadow.tuning().gains.nominal_inertia;
        match ServedFlight::mirror(mirrored, first, &tuning) {
            Ok(served) => {
                self.take_off(served);
                self.warm_up = warm_up;
            }
            Err(error) => {
                self.hub.notice(client, NoticeLevel::Error, &format!("seek refused: {error}"));
            }
        }
    }
}
