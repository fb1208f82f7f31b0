//! What waits for one client: a bounded ring of telemetry rows, the newest picture, and messages.
//!
//! The flight never waits for a client. A slow one loses its oldest rows and is told how many; messages are never lost,
//! because a client that lets too many pile up is sent everything anew instead.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::server::hub::Published;
use crate::server::telemetry::{Picture, Telemetry};

/// Rows that wait at most: 5 s of flight.
pub(super) const MOST_ROWS: usize = 512;

/// Messages that wait at most.
pub(super) const MOST_MESSAGES: usize = 512;

/// A message that waits.
#[derive(Clone, Debug)]
pub(super) enum Message {
    /// JSON, shared by all clients.
    Json(Arc<str>),
    /// A `hello`, to be written out for this client.
    Hello(Arc<Published>),
}

/// Why a connection is closed by the server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Farewell {
    /// Close code of RFC 6455.
    pub code: u16,
    /// One sentence.
    pub reason: String,
}

/// What waits for one client.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    messages: VecDeque<Message>,
    rows: VecDeque<Arc<[f32]>>,
    first_tick: u64,
    gap: u32,
    reset: bool,
    picture: Option<Arc<Picture>>,
    schema_id: u16,
    farewell: Option<Farewell>,
}

/// All that waited, to be sent in this order.
#[derive(Debug, Default)]
pub(super) struct Parcel {
    /// Messages first: a `hello` comes before the rows it describes.
    pub messages: Vec<Message>,
    /// Rows with the newest picture.
    pub telemetry: Option<Telemetry>,
    /// Close the connection after the rest.
    pub farewell: Option<Farewell>,
}

impl Outbox {
    /// Puts a tick in; the oldest row goes if the ring is full.
    pub(super) fn push_tick(&mut self, tick: u64, row: Arc<[f32]>, picture: Arc<Picture>) {
        if self.rows.is_empty() {
            self.first_tick = tick;
        }
        if self.rows.len() == MOST_ROWS {
            self.rows.pop_front();
            self.first_tick += 1;
            self.gap = self.gap.saturating_add(1);
        }
        self.rows.push_back(row);
        self.picture = Some(picture);
    }

    /// Puts a message in; `false` if too many wait, and then nothing changed.
    #[must_use]
    pub(super) fn push_message(&mut self, message: Message) -> bool {
        let fits = self.messages.len() < MOST_MESSAGES;
        if fits {
            self.messages.push_back(message);
        }
        fits
    }

    /// Replaces all waiting messages by a `hello`, which says the same.
    pub(super) fn start_over(&mut self, published: Arc<Published>) {
        self.messages.clear();
        self.messages.push_back(Message::Hello(published));
    }

    /// Throws the rows of the flight before away; the next frame belongs to `schema_id`.
    pub(super) fn begin(&mut self, schema_id: u16, reset: bool) {
        self.rows.clear();
        self.picture = None;
        self.gap = 0;
        self.reset = reset;
        self.schema_id = schema_id;
    }

    /// Closes the connection after what waits.
    pub(super) fn close(&mut self, farewell: Farewell) {
        self.farewell.get_or_insert(farewell);
    }

    /// Takes all that waits.
    pub(super) fn take(&mut self) -> Parcel {
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
        Parcel {
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
            };
            outbox.push_tick(tick, [tick as f32].into(), Arc::new(picture));
        }
    }

    fn ticks_of(telemetry: &Telemetry) -> Vec<u64> {
        telemetry.rows.iter().map(|row| row[0] as u64).collect()
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
    fn too_many_messages_are_refused_and_none_of_the_waiting_is_lost() {
        let mut outbox = Outbox::default();
        for number in 0..MOST_MESSAGES {
            assert!(outbox.push_message(Message::Json(number.to_string().into())));
        }
        assert!(!outbox.push_message(Message::Json("one too many".into())));
        let messages = outbox.take().messages;
        assert_eq!(messages.len(), MOST_MESSAGES);
        assert!(matches!(&messages[0], Message::Json(text) if &**text == "0"));
    }
}
