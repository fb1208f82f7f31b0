//! A mirrored flight: the way to any tick of it. If it still goes on, the next tick may be still to come, and the stream may begin
//! anew.

use std::sync::Arc;

use super::{Pilot, Sortie};
use crate::server::mirrored::Mirrored;
use crate::server::protocol::NoticeLevel;

/// So far beyond what there is of it: its clock was set back.
const FAR_AHEAD_TICKS: u64 = 100;

impl Pilot {
    /// The next tick of a flight that still goes on is still to come.
    pub(super) fn is_ahead(&self) -> bool {
        let live = self.sortie.mirrored.as_ref().filter(|mirrored| mirrored.is_live());
        live.is_some_and(|live| self.sortie.next_tick >= live.shadow.ticks() as u64)
    }

    /// Looks after a flight that still goes on: what is new of it, and whether it goes on elsewhere.
    pub(super) fn attend(&mut self) {
        let Some(mirrored) = self.sortie.mirrored.clone().filter(|mirrored| mirrored.is_live())
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
        } else if edge > 0 && self.sortie.next_tick > edge + FAR_AHEAD_TICKS {
            self.go_to(&mirrored, f64::MAX, None);
        }
    }

    /// The last tick of a recording is flown.
    pub(super) fn is_at_end(&self) -> bool {
        let ended = self.sortie.mirrored.as_ref().filter(|mirrored| !mirrored.is_live());
        let ticks = ended.map(|mirrored| mirrored.shadow.ticks() as u64);
        ticks.is_some_and(|ticks| self.sortie.next_tick >= ticks)
    }

    /// Goes to a time of the recording, with the gains in force.
    pub(super) fn seek(&mut self, t_s: f64, client: Option<u64>) {
        if let Some(mirrored) = self.sortie.mirrored.clone() {
            self.go_to(&mirrored, t_s, client);
        }
    }

    fn go_to(&mut self, mirrored: &Arc<Mirrored>, t_s: f64, client: Option<u64>) {
        let (first, warm_up) = mirrored.run_up(t_s);
        let mut tuning = *self.sortie.flight.tuning();
        // The mass of a stream that is judged anew may be another.
        tuning.gains.nominal_inertia = mirrored.shadow.tuning().gains.nominal_inertia;
        match Sortie::mirror(mirrored, first, &tuning) {
            Ok(sortie) => {
                self.take_off(sortie);
                self.warm_up = warm_up;
            }
            Err(error) => {
                self.hub.notice(client, NoticeLevel::Error, &format!("seek refused: {error}"));
            }
        }
    }
}
