//! The outbox of one client: a bounded ring of telemetry rows, the newest picture, and messages.
//!
//! The flight never waits for a client. A slow client loses its oldest rows and is told how many. It loses no message without
//! a replacement: if too many messages wait, a `hello` with the whole state replaces them.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::server::protocol::ServerMessage;
use crate::server::published::Published;
use crate::server::telemetry::{Picture, Telemetry};

/// Most rows that wait: 5 s of flight.
pub(super) const MOST_ROWS: usize = 512;

/// Most rows of the past that a new client gets: a minute of flight.
const PAST_ROWS: usize = 6000;

/// Most messages that wait.
pub(super) const MOST_MESSAGES: usize = 512;

/// A message with its JSON text, which is made once for all clients. Clients that speak no JSON use the message itself.
#[derive(Debug)]
pub(super) struct SharedMessage {
    /// The message.
    pub message: ServerMessage,
    /// The message as JSON, for the console.
    pub text: String,
}

impl From<ServerMessage> for SharedMessage {
    fn from(message: ServerMessage) -> Self {
        let text = serde_json::to_string(&message)
            .inspect_err(|error| tracing::error!("cannot write a message as JSON: {error}"))
            .unwrap_or_default();
        Self { message, text }
    }
}

/// A message in an outbox.
#[derive(Clone, Debug)]
pub(super) enum Message {
    /// A message that is the same for all clients.
    Shared(Arc<SharedMessage>),
    /// A `hello`, which is written separately for each client.
    Hello(Arc<Published>),
}

/// The reason why the server closes a connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CloseReason {
    /// Close code of RFC 6455.
    pub code: u16,
    /// The reason in one sentence.
    pub reason: String,
}

/// The newest rows of a flight and the newest picture, for clients that join later.
#[derive(Debug, Default)]
pub(super) struct RecentRows {
    rows: VecDeque<Arc<[f32]>>,
    first_tick: u64,
    picture: Option<Arc<Picture>>,
}

impl RecentRows {
    /// Adds a tick. A tick that does not follow the last one clears the past first.
    pub(super) fn push_tick(&mut self, tick: u64, row: Arc<[f32]>, picture: Arc<Picture>) {
        if tick != self.first_tick + self.rows.len() as u64 {
            self.rows.clear();
            self.first_tick = tick;
        }
        if self.rows.len() == PAST_ROWS {
            self.rows.pop_front();
            self.first_tick += 1;
        }
        self.rows.push_back(row);
        self.picture = Some(picture);
    }
}

/// The rows, the picture and the messages that wait for one client.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    messages: VecDeque<Message>,
    rows: VecDeque<Arc<[f32]>>,
    /// Number of `rows` that came with the past; they do not count against [`MOST_ROWS`].
    past_rows: usize,
    first_tick: u64,
    gap: u32,
    reset: bool,
    picture: Option<Arc<Picture>>,
    schema_id: u16,
    farewell: Option<CloseReason>,
}

/// The content of an outbox, in the order in which it is sent.
#[derive(Debug, Default)]
pub(super) struct OutboxContent {
    /// Messages. They come first, because a `hello` describes the rows that follow.
    pub messages: Vec<Message>,
    /// Rows with the newest picture.
    pub telemetry: Option<Telemetry>,
    /// The reason if the connection closes after the rest was sent.
    pub farewell: Option<CloseReason>,
}

impl OutboxContent {
    /// Cuts the parcel into parts of at most `most` rows. The first part has the messages, and each part has the newest picture.
    pub(super) fn parts(self, most: usize) -> impl Iterator<Item = Self> {
        let mut messages = Some(self.messages);
        let mut rest = self.telemetry;
        std::iter::from_fn(move || {
            let telemetry = rest.take().map(|mut part| {
                if part.rows.len() > most {
                    rest = Some(part.split_off(most));
                }
                part
            });
            let due = messages.is_some() || telemetry.is_some();
            let messages = messages.take().unwrap_or_default();
            due.then_some(Self { messages, telemetry, farewell: None })
        })
    }
}

impl Outbox {
    /// Adds a tick; drops the oldest row if the ring is full.
    pub(super) fn push_tick(&mut self, tick: u64, row: Arc<[f32]>, picture: Arc<Picture>) {
        if self.rows.is_empty() {
            self.first_tick = tick;
        }
        if self.rows.len() >= MOST_ROWS + self.past_rows {
            self.rows.pop_front();
            self.first_tick += 1;
            self.gap = self.gap.saturating_add(1);
        }
        self.rows.push_back(row);
        self.picture = Some(picture);
    }

    /// Adds the past for a client that has just joined.
    pub(super) fn catch_up(&mut self, past: &RecentRows) {
        self.rows.clone_from(&past.rows);
        self.past_rows = past.rows.len();
        self.first_tick = past.first_tick;
        self.picture.clone_from(&past.picture);
    }

    /// Adds a message; returns `false` and leaves the outbox unchanged if too many messages wait.
    #[must_use]
    pub(super) fn push_message(&mut self, message: Message) -> bool {
        let fits = self.messages.len() < MOST_MESSAGES;
        if fits {
            self.messages.push_back(message);
        }
        fits
    }

    /// Replaces all waiting messages by a `hello`, which contains the state that they led to.
    pub(super) fn start_over(&mut self, published: Arc<Published>) {
        self.messages.clear();
        self.messages.push_back(Message::Hello(published));
    }

    /// Drops the rows of the last flight; the next frame belongs to `schema_id`. With `reset` the next frame tells the client to
    /// drop the rows that it has.
    pub(super) fn begin(&mut self, schema_id: u16, reset: bool) {
        self.rows.clear();
        self.past_rows = 0;
        self.picture = None;
        self.gap = 0;
        self.reset = reset;
        self.schema_id = schema_id;
    }

    /// Closes the connection after the waiting rows and messages were sent.
    pub(super) fn close(&mut self, farewell: CloseReason) {
        self.farewell.get_or_insert(farewell);
    }

    /// Whether the connection closes.
    pub(super) fn is_closing(&self) -> bool {
        self.farewell.is_some()
    }

    /// Takes everything out of the outbox.
    pub(super) fn take(&mut self) -> OutboxContent {
        self.past_rows = 0;
        let telemetry = match (&self.picture, self.rows.is_empty()) {
            (Some(picture), false) => Some(Telemetry {
                schema_id: self.schema_id,
                first_tick: self.first_tick,
                rows: self.rows.drain(..).collect(),
                gap: std::mem::take(&mut self.gap),
                reset: std::mem::take(&mut self.reset),
                picture: Arc::clone(picture),
            }),
            _ => None,
        };
        OutboxContent {
            messages: self.messages.drain(..).collect(),
            telemetry,
            farewell: self.farewell.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn push(outbox: &mut Outbox, ticks: std::ops::Range<u64>) {
        for tick in ticks {
            let picture = Picture {
                t_s: tick as f64,
                poses: Vec::new(),
                ghost: [0.0; 7],
                contacts: Vec::new(),
                spectrum: Vec::new(),
            };
            outbox.push_tick(tick, [tick as f32].into(), Arc::new(picture));
        }
    }

    fn ticks_of(telemetry: &Telemetry) -> Vec<u64> {
        telemetry.rows.iter().map(|row| row[0] as u64).collect()
    }

    fn pong(t: f64) -> Message {
        Message::Shared(Arc::new(ServerMessage::Pong { t, t_s: 0.0 }.into()))
    }

    #[test]
    fn the_newest_rows_survive_and_the_gap_counts_the_others() {
        let mut outbox = Outbox::default();
        let most = MOST_ROWS as u64;
        push(&mut outbox, 10..10 + most + 7);
        let telemetry = outbox.take().telemetry.unwrap();
        assert_eq!((telemetry.first_tick, telemetry.gap), (17, 7));
        assert_eq!(ticks_of(&telemetry), (17..17 + most).collect::<Vec<_>>());
        assert_eq!(telemetry.picture.t_s.to_bits(), ((16 + most) as f64).to_bits());
    }

    #[test]
    fn a_reader_that_keeps_up_sees_every_tick_once_and_no_gap() {
        let mut outbox = Outbox::default();
        let mut seen = Vec::new();
        for start in (0..1000).step_by(100) {
            push(&mut outbox, start..start + 100);
            let telemetry = outbox.take().telemetry.unwrap();
            assert_eq!((telemetry.gap, telemetry.first_tick), (0, start));
            seen.extend(ticks_of(&telemetry));
        }
        assert_eq!(seen, (0..1000).collect::<Vec<_>>());
        assert!(outbox.take().telemetry.is_none());
    }

    #[test]
    fn the_gap_is_reported_once() {
        let mut outbox = Outbox::default();
        push(&mut outbox, 0..MOST_ROWS as u64 + 3);
        assert_eq!(outbox.take().telemetry.unwrap().gap, 3);
        push(&mut outbox, MOST_ROWS as u64 + 3..MOST_ROWS as u64 + 5);
        assert_eq!(outbox.take().telemetry.unwrap().gap, 0);
    }

    #[test]
    fn a_restart_throws_old_rows_away_and_marks_the_first_new_frame_only() {
        let mut outbox = Outbox::default();
        push(&mut outbox, 0..900);
        outbox.begin(2, true);
        push(&mut outbox, 0..1);
        let first = outbox.take().telemetry.unwrap();
        assert_eq!(
            (first.schema_id, first.reset, first.gap, ticks_of(&first)),
            (2, true, 0, vec![0])
        );
        push(&mut outbox, 1..2);
        assert!(!outbox.take().telemetry.unwrap().reset);
    }

    #[test]
    fn a_client_that_comes_late_gets_the_past_once_and_then_what_follows() {
        let mut past = RecentRows::default();
        let last = PAST_ROWS as u64 + 40;
        let mut given = Outbox::default();
        push(&mut given, 0..last);
        for (tick, row) in (0..last).map(|tick| (tick, Arc::from([tick as f32]))) {
            past.push_tick(tick, row, Arc::clone(given.picture.as_ref().unwrap()));
        }
        let mut outbox = Outbox::default();
        outbox.begin(3, false);
        outbox.catch_up(&past);
        push(&mut outbox, last..last + MOST_ROWS as u64);
        let first = outbox.take().telemetry.unwrap();
        assert_eq!((first.first_tick, first.gap, first.reset), (40, 0, false));
        assert_eq!(ticks_of(&first), (40..last + MOST_ROWS as u64).collect::<Vec<_>>());
        // The client has taken the past; from now on the limit of `MOST_ROWS` holds.
        push(&mut outbox, 0..MOST_ROWS as u64 + 1);
        assert_eq!(outbox.take().telemetry.unwrap().gap, 1);
    }

    #[test]
    fn parts_have_every_row_once_and_messages_gap_and_reset_come_with_the_first() {
        let mut outbox = Outbox::default();
        outbox.begin(7, true);
        assert!(outbox.push_message(pong(1.0)));
        push(&mut outbox, 0..MOST_ROWS as u64 + 3);
        let parts: Vec<OutboxContent> = outbox.take().parts(200).collect();
        let rows: Vec<Telemetry> = parts.iter().filter_map(|part| part.telemetry.clone()).collect();
        assert_eq!(
            rows.iter().flat_map(ticks_of).collect::<Vec<_>>(),
            (3..515).collect::<Vec<_>>()
        );
        let heads: Vec<_> = rows
            .iter()
            .map(|t| (t.schema_id, t.first_tick, t.rows.len(), t.gap, t.reset))
            .collect();
        assert_eq!(heads, [(7, 3, 200, 3, true), (7, 203, 200, 0, false), (7, 403, 112, 0, false)]);
        let messages: Vec<usize> = parts.iter().map(|part| part.messages.len()).collect();
        assert_eq!(messages, [1, 0, 0]);
        // Without rows there is one part, which has the messages.
        assert!(outbox.push_message(pong(2.0)));
        assert_eq!(outbox.take().parts(200).count(), 1);
    }

    #[test]
    fn a_tick_that_does_not_follow_begins_a_new_past() {
        let mut past = RecentRows::default();
        let mut given = Outbox::default();
        push(&mut given, 0..1);
        let picture = given.picture.unwrap();
        for tick in [5, 6, 7, 20, 21, 3] {
            past.push_tick(tick, [tick as f32].into(), Arc::clone(&picture));
        }
        assert_eq!((past.first_tick, past.rows.len()), (3, 1));
        past.push_tick(4, [4.0].into(), picture);
        assert_eq!((past.first_tick, past.rows.len()), (3, 2));
    }

    #[test]
    fn too_many_messages_are_refused_and_none_of_the_waiting_is_lost() {
        let mut outbox = Outbox::default();
        for number in 0..MOST_MESSAGES {
            assert!(outbox.push_message(pong(number as f64)));
        }
        assert!(!outbox.push_message(pong(-1.0)));
        let messages = outbox.take().messages;
        assert_eq!(messages.len(), MOST_MESSAGES);
        assert!(matches!(&messages[0], Message::Shared(told) if told.text.contains("\"t\":0.0")));
    }
}
