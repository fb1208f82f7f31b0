//! Requests before they are carried out, and the gains that they changed.

use super::Pilot;
use crate::server::command::{BUSY, Command, Request};
use crate::server::protocol::{NoticeLevel, ServerMessage};
use crate::server::served_flight::ServedFlight;

impl Pilot {
    /// Puts a request on the agenda. A mirrored flight starts anew by a seek to its start.
    pub(super) fn plan(&mut self, mut request: Request) {
        if self.served.mirrored.is_some() && matches!(request.command, Command::Restart { .. }) {
            request.command = Command::Seek(0.0);
        }
        if let Some(refused) = self.agenda.add(request) {
            self.hub.notice(refused.client, NoticeLevel::Error, BUSY);
        }
    }

    /// Applies the changes of gains that were carried out since the last tick, and tells all clients.
    pub(super) fn apply_changes(&mut self) {
        if self.changes.is_empty() {
            return;
        }
        let changes = std::mem::take(&mut self.changes);
        let ServedFlight { presets, flight, next_tick, .. } = &mut self.served;
        let applied = presets.apply(flight, changes, *next_tick);
        self.forks.tuned(*next_tick, flight.tuning());
        let (preset, base) = (presets.preset(flight.tuning()), presets.base());
        let gains = self.served.gains();
        self.hub.publish(|published| {
            published.gains = gains;
            published.preset = preset;
            published.base = base;
            let echoes = applied.echoes.into_iter().map(ServerMessage::Gain);
            echoes.chain(applied.list.map(ServerMessage::Gains)).collect()
        });
    }
}
