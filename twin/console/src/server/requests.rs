//! What a client asks of the server: its frames are charged, its commands are checked, and both go on to the flight.

use std::sync::mpsc::TrySendError;

use tokio_tungstenite::tungstenite::Error;

use crate::server::App;
use crate::server::admission::budget::{ONE_PER_S, Pace, cost};
use crate::server::admission::refusals::Refusal;
use crate::server::command::{self, BUSY, Request};
use crate::server::hub::Client;
use crate::server::mirrored;
use crate::server::outbox::CloseReason;
use crate::server::pace::now;
use crate::server::protocol::{ClientMessage, NoticeLevel};
use crate::server::socket::{code, farewell};

impl App {
    /// Charges a frame to a client, and waits while the client or all clients together are in debt. Returns `false` if the connection
    /// ends, because the client is in debt for too long.
    pub(super) async fn paced(&self, client: &Client) -> bool {
        let also = self.admission.overall().debt(now());
        let pace = client.budget().frame(now(), also);
        let wait = match pace {
            Pace::Go => return true,
            Pace::Wait(wait) => wait,
            Pace::Warn(wait) => {
                let told = format!(
                    "more than {ONE_PER_S} messages per second, or commands as costly; they wait, slow down"
                );
                self.admission
                    .refusals
                    .note(Refusal::Rate, &format_args!("client {}: {told}", client.id));
                client.notice(NoticeLevel::Warning, told);
                wait
            }
            Pace::Close => {
                let why =
                    format!("more than {ONE_PER_S} messages per second in spite of a warning");
                self.admission
                    .refusals
                    .note(Refusal::Rate, &format_args!("client {}: {why}", client.id));
                client.close(code::POLICY, why);
                return false;
            }
        };
        tokio::time::sleep(wait).await;
        true
    }

    /// Closes the connection of a client with the code that belongs to `error`.
    pub(super) fn dismiss(&self, error: &Error, client: &Client) {
        if let Some((CloseReason { code, reason }, refusal)) = farewell(error) {
            self.admission.refusals.note(refusal, &format_args!("client {}: {reason}", client.id));
            client.close(code, reason);
        }
    }

    /// Counts a client that took no data.
    pub(super) fn note_stalled(&self, client: &Client) {
        let s = self.admission.limits.stalled.as_secs_f64();
        let what = format_args!("client {} took no data for {s} s", client.id);
        self.admission.refusals.note(Refusal::Stalled, &what);
    }

    /// Checks a request of a client and hands it to the flight; tells the client if the request is refused.
    pub(super) fn obey(&self, message: ClientMessage, client: &Client) {
        if let Some(why) = mirrored::refusal(&message, self.mirrored) {
            return client.notice(NoticeLevel::Warning, why);
        }
        match command::check(message, &self.scenarios, &self.tuning) {
            Ok(Some(command)) => {
                // The frame itself was charged already.
                client.budget().charge(cost(&command) - 1.0, now());
                if let Err(why) = self.ask(Request { client: Some(client.id), command }) {
                    client.notice(NoticeLevel::Error, why);
                }
            }
            Ok(None) => {}
            Err(error) => client.notice(NoticeLevel::Warning, error.to_string()),
        }
    }

    /// Hands a request to the flight without waiting.
    ///
    /// # Errors
    /// A sentence for the operator if the queue of requests is full or the flight has stopped.
    pub(super) fn ask(&self, request: Request) -> Result<(), &'static str> {
        self.admission.overall().charge(cost(&request.command), now());
        self.requests.try_send(request).map_err(|error| match error {
            TrySendError::Full(_) => {
                self.admission.refusals.note(Refusal::Busy, &BUSY);
                BUSY
            }
            TrySendError::Disconnected(_) => "the flight has stopped; start the server again",
        })
    }
}
