//! Playback of a mirrored recording: handles the requests of Foxglove's timeline and tells it the state of the playback.
//!
//! A seek starts the shadow some seconds before the target, and flies up to it. The console's charts show the rows before the
//! target. Foxglove must not get them, because their times lie before the time that its user asked for.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use foxglove::websocket::{PlaybackCommand, PlaybackControlRequest, PlaybackState, PlaybackStatus};

use crate::server::App;
use crate::server::foxglove::topics::nanoseconds;
use crate::server::hub::Client;
use crate::server::protocol::{ClientMessage, FlightPhase, MirrorInfo, StateInfo};
use crate::server::telemetry::Telemetry;

/// Speeds that differ by less than this are equal, because the protocol carries them as f32.
const SAME_SPEED: f64 = 1e-4;

/// Handles the requests of the timeline, which come from Foxglove's threads.
pub(super) struct PlaybackRequests {
    app: Arc<App>,
    bridge: Arc<Client>,
    info: Arc<MirrorInfo>,
    /// The timeline itself asked for the seek that is under way, and the answer has told it so.
    announced: AtomicBool,
}

impl PlaybackRequests {
    /// `None` if no recording is mirrored.
    pub(super) fn new(app: &Arc<App>, bridge: &Arc<Client>) -> Option<Self> {
        Some(Self {
            info: app.hub.published().mirror?,
            app: Arc::clone(app),
            bridge: Arc::clone(bridge),
            announced: AtomicBool::new(false),
        })
    }

    /// First and last time of the recording, ns.
    pub(super) fn range(&self) -> (u64, u64) {
        (0, nanoseconds(self.info.duration_s))
    }

    /// Passes a request on to the flight, as if the console had sent it. Returns the playback state to be expected; the
    /// publisher tells the real state when the flight has handled the request.
    pub(super) fn obey(&self, request: &PlaybackControlRequest) -> PlaybackState {
        let mut answer = self.state(&self.app.hub.published().state, false);
        let speed = f64::from(request.playback_speed);
        if (speed - f64::from(answer.playback_speed)).abs() > SAME_SPEED || speed.is_nan() {
            self.app.obey(ClientMessage::Speed { value: Some(speed) }, &self.bridge);
        }
        if let Some(time) = request.seek_time {
            self.announced.store(true, Ordering::Relaxed);
            self.app.obey(ClientMessage::Seek { t_s: time as f64 * 1e-9 }, &self.bridge);
            answer.current_time = time;
            answer.did_seek = true;
        }
        let paused = request.playback_command == PlaybackCommand::Pause;
        self.app.obey(ClientMessage::Pause { paused }, &self.bridge);
        answer.status = match (request.seek_time, paused) {
            (Some(_), _) => PlaybackStatus::Buffering,
            (None, true) => PlaybackStatus::Paused,
            (None, false) => PlaybackStatus::Playing,
        };
        answer
    }

    /// The playback state that belongs to the state of the flight.
    fn state(&self, state: &StateInfo, did_seek: bool) -> PlaybackState {
        let status = match state.phase {
            FlightPhase::Flying => PlaybackStatus::Playing,
            _ if state.tick >= self.info.ticks => PlaybackStatus::Ended,
            _ => PlaybackStatus::Paused,
        };
        // The protocol has no word for "as fast as possible"; the measured speed stands for it.
        let speed = state.speed.unwrap_or(state.real_time_factor) as f32;
        PlaybackState {
            status,
            current_time: nanoseconds(state.t_s),
            playback_speed: if speed > 0.0 { speed } else { 1.0 },
            did_seek,
            request_id: None,
        }
    }
}

/// The progress of a seek.
enum Seek {
    None,
    /// The shadow flies up to the target. The newest rows are kept, because their last row may be the target's.
    UnderWay(Option<Telemetry>),
    /// The seek to this tick is complete, but its row has not arrived.
    Reached(u64),
}

/// Chooses for the publisher the rows and the playback states that Foxglove gets.
pub(super) struct PlaybackFilter {
    playback: Arc<PlaybackRequests>,
    seek: Seek,
    told: Option<(PlaybackStatus, u32)>,
}

impl PlaybackFilter {
    /// Starts with a seek under way, because the playback may start in the middle of the recording.
    pub(super) fn new(playback: Arc<PlaybackRequests>) -> Self {
        Self { playback, seek: Seek::UnderWay(None), told: None }
    }

    /// The flight starts anew and flies up to the target of a seek.
    pub(super) fn reset(&mut self) {
        self.seek = Seek::UnderWay(None);
    }

    /// Whether a seek is under way, during which Foxglove gets no messages.
    pub(super) fn is_under_way(&self) -> bool {
        matches!(self.seek, Seek::UnderWay(_))
    }

    /// Takes the new state of the flight. Returns the playback state if it is new to Foxglove, and the rows from the target of a
    /// seek on if the seek is complete and the rows have arrived.
    pub(super) fn follow(
        &mut self,
        state: &StateInfo,
    ) -> (Option<PlaybackState>, Option<Telemetry>) {
        let reached = match std::mem::replace(&mut self.seek, Seek::None) {
            Seek::UnderWay(newest) => {
                let target = state.tick.saturating_sub(1);
                let row = newest.and_then(|telemetry| since(telemetry, target));
                self.seek = if row.is_some() { Seek::None } else { Seek::Reached(target) };
                let announced = self.playback.announced.swap(false, Ordering::Relaxed);
                Some((!announced, row))
            }
            other => {
                self.seek = other;
                None
            }
        };
        let (did_seek, row) = reached.unwrap_or((false, None));
        let now = self.playback.state(state, did_seek);
        let key = Some((now.status, (now.playback_speed * 100.0).round() as u32));
        let news = did_seek || row.is_some() || key != self.told;
        self.told = key;
        (news.then_some(now), row)
    }

    /// The part of these rows that Foxglove gets now.
    pub(super) fn cut(&mut self, telemetry: Telemetry) -> Option<Telemetry> {
        match self.seek {
            Seek::None => Some(telemetry),
            Seek::UnderWay(ref mut newest) => {
                *newest = Some(telemetry);
                None
            }
            Seek::Reached(target) => {
                let rest = since(telemetry, target)?;
                self.seek = Seek::None;
                Some(rest)
            }
        }
    }
}

/// The rows from `tick` on; `None` if there are none.
fn since(mut telemetry: Telemetry, tick: u64) -> Option<Telemetry> {
    let before = tick.saturating_sub(telemetry.first_tick) as usize;
    if before >= telemetry.rows.len() {
        return None;
    }
    telemetry.rows.drain(..before);
    telemetry.first_tick += before as u64;
    Some(telemetry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::viewers::fixture::flown;

    #[test]
    fn rows_before_the_target_of_a_seek_are_left_out() {
        let telemetry = || flown(10..15, |tick| vec![tick as f32]);
        let from = |tick| {
            since(telemetry(), tick).map(|rest| {
                let rows: Vec<u64> = rest.rows.iter().map(|row| row[0] as u64).collect();
                (rest.first_tick, rows)
            })
        };
        assert_eq!(from(3), Some((10, vec![10, 11, 12, 13, 14])));
        assert_eq!(from(12), Some((12, vec![12, 13, 14])));
        assert_eq!(from(14), Some((14, vec![14])));
        assert_eq!(from(15), None);
    }
}
