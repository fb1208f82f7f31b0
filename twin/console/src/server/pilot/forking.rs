//! Forks that operators ask for.

use super::Pilot;
use crate::server::command::Asked;
use crate::server::protocol::{NoticeLevel, ServerMessage};

impl Pilot {
    /// Begins a fork; a refusal goes to the client that asked.
    pub(super) fn fork(&mut self, asked: Asked, client: Option<u64>) {
        match self.forks.begin(asked, &self.served) {
            Ok(()) => self.publish_forks(),
            Err(refusal) => self.hub.notice(client, NoticeLevel::Warning, &refusal.to_string()),
        }
    }

    /// Names a fork, or drops it if there is no name.
    pub(super) fn change_fork(&mut self, id: u32, name: Option<&str>, client: Option<u64>) {
        let forks = &self.hub.forks;
        if name.map_or_else(|| forks.drop_fork(id), |name| forks.rename(id, name)) {
            return self.publish_forks();
        }
        let text = format!(
            "fork {id} refused: there is no such fork; it was dropped, or the flight began anew"
        );
        self.hub.notice(client, NoticeLevel::Warning, &text);
    }

    fn publish_forks(&self) {
        let forks = self.hub.forks.infos();
        self.hub.publish(|_| vec![ServerMessage::Forks { forks }]);
    }
}
