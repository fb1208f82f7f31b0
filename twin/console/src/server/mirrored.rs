//! A mirrored flight in the server: the recording in shadow, a stand-in to draw, and the messages that are refused.

use std::path::PathBuf;
use std::sync::Arc;

use crate::server::protocol::{ClientMessage, EventInfo, MirrorInfo, TwinAxis, TwinInfo};
use twin_core::notation::{COORDINATE_NAMES, TICK_S};
use twin_core::tick::EventKind;
use twin_foreign::divergence::HORIZONS;
use twin_foreign::gate;
use twin_foreign::phases::Span;
use twin_foreign::shadow::GHOST_TICKS;
use twin_foreign::shadow_score::Score;
use twin_foreign::{Flyer, Knowledge, Light, Shadow, Twin};
use twin_foreign::{Forecaster, Live, OpenedFlight};

/// Number of ticks that a seek flies before its target: the adapter forgets within a second, and the charts show a past.
const WARM_UP_TICKS: usize = 1000;

/// Number of ticks by which playback stays behind the newest tick of a live flight, because new ticks arrive a few at a time.
const BEHIND_TICKS: usize = 6;

/// Largest number of phases that the description lists.
const SHOWN_SPANS: usize = 20;

/// Groups of channels without data in a mirrored flight: the recorded vehicle flew its own controller.
pub(super) const NOT_IN_FORCE: [&str; 4] = ["robust", "actuators", "gripper", "world"];

/// A recording that the server plays.
pub(super) struct Mirrored {
    /// Description for clients.
    pub info: MirrorInfo,
    /// The recording in shadow.
    pub shadow: Shadow,
    /// Flies the twin beside the recording.
    flyer: Flyer,
    /// Name of the file.
    pub name: String,
    /// The file.
    pub path: PathBuf,
    /// The live stream, if the flight still goes on, and its generation when it was opened.
    live: Option<(Arc<Live>, u64)>,
}

impl Mirrored {
    /// The mirror of an opened recording.
    pub(super) fn new(
        opened: &OpenedFlight,
        live: Option<Arc<Live>>,
        forecaster: &Forecaster,
    ) -> Self {
        let live = live.map(|live| {
            let generation = live.generation();
            (live, generation)
        });
        let recorded = &opened.recorded;
        let shadow = Shadow::of(opened).with(forecaster.clone());
        let flyer = Flyer::new(shadow.playback(), opened, Twin::of(opened));
        let known =
            |row: usize| (0..recorded.instants.len()).any(|t| recorded.residual_counts(t, row));
        let unknown = COORDINATE_NAMES.iter().enumerate().filter(|(row, _)| !known(*row));
        let vehicle = &opened.map.vehicle.name;
        let vehicle = if vehicle.is_empty() { "unknown vehicle" } else { vehicle };
        let joints = match &recorded.joint_names[..] {
            [] => "no joint is in the recording".to_owned(),
            names => format!("its joints {} are in the charts only", names.join(", ")),
        };
        let phase = |span: &Span| {
            let (from_s, to_s, phase) = (span.from_s, span.to_s, span.phase.words());
            format!("{from_s:.1} to {to_s:.1} s {phase}: {}", span.why)
        };
        let phases: Vec<String> = recorded.spans.iter().take(SHOWN_SPANS).map(phase).collect();
        let (force, torque) = (opened.force_sentence(), opened.torque_sentence());
        let info = MirrorInfo {
            file: live.as_ref().map_or_else(|| opened.name(), |(live, _)| live.name().to_owned()),
            map: opened.map_name.clone(),
            vehicle: vehicle.to_owned(),
            stand_in: format!("a plain quadrotor is drawn for the vehicle, {joints}"),
            ghost: format!(
                "where the twin expected the vehicle from what it knew {:.1} s before",
                GHOST_TICKS as f64 * TICK_S
            ),
            predictor: forecaster.sentence(),
            force: if opened.per_kilogram() {
                format!("{force}; the mass is unknown, so forces are per kilogram; {torque}")
            } else {
                format!("{force}; mass in use {:.3} kg; {torque}", recorded.mass_kg)
            },
            unknown_rows: unknown.map(|(_, row)| (*row).to_owned()).collect(),
            ticks: shadow.ticks() as u64,
            duration_s: shadow.ticks() as f64 * TICK_S,
            live: live.is_some(),
            notes: [&opened.survey.container.problems[..], &opened.signals.notes[..], &phases[..]]
                .concat(),
            per_kilogram: opened.per_kilogram(),
            phases: shadow.knowledge().iter().map(event).collect(),
        };
        Self { info, shadow, flyer, name: opened.name(), path: opened.path.clone(), live }
    }

    /// The mirror of the newly opened stream if its generation changed since; otherwise `None`.
    pub(super) fn renewed(&self) -> Option<Self> {
        let (live, generation) = self.live.as_ref()?;
        if live.generation() == *generation {
            return None;
        }
        Some(Self::new(&live.opened()?, Some(Arc::clone(live)), self.shadow.forecaster()))
    }

    /// True if it mirrors a live stream.
    pub(super) fn is_live(&self) -> bool {
        self.live.is_some()
    }

    /// True if it mirrors a live stream that sends nothing.
    pub(super) fn is_lost(&self) -> bool {
        self.live.as_ref().is_some_and(|(live, _)| !live.is_up())
    }

    /// One sentence for each event of the stream since the last call.
    pub(super) fn news(&self) -> Vec<String> {
        self.live.as_ref().map_or_else(Vec::new, |(live, _)| live.news())
    }

    /// Error of the twin near `tick`, half a second after its start, and how the forecasts of `score` did so far.
    pub(super) fn beside(&self, tick: usize, score: &Score) -> TwinInfo {
        // The twin starts earlier by the ticks that its delayed commands need, because a live stream has no data after `tick`.
        let start = tick.checked_sub(self.flyer.reach(HORIZONS[1]));
        let misses = start.and_then(|start| self.flyer.half_second(start));
        let prediction = score.prediction();
        let axis = |(row, miss): (&&str, &twin_foreign::PredictionError)| {
            let (twin, with_residual, coasting) = (miss.twin?, miss.with_residual?, miss.coasting?);
            Some(TwinAxis { row: (*row).to_owned(), twin, with_residual, coasting })
        };
        TwinInfo {
            says: self.flyer.says().to_owned(),
            horizon_s: HORIZONS[1] as f64 * TICK_S,
            gate: gate::sentence(&prediction),
            gate_passed: gate::is_passed(&prediction),
            light: misses.as_ref().and_then(Light::worst),
            axes: misses
                .iter()
                .flat_map(|m| COORDINATE_NAMES.iter().zip(m))
                .filter_map(axis)
                .collect(),
        }
    }

    /// The tick at `t_s` of the recording, limited to its length.
    pub(super) fn tick_at(&self, t_s: f64) -> usize {
        let behind = if self.is_live() { BEHIND_TICKS } else { 0 };
        let last = self.shadow.ticks().saturating_sub(1 + behind);
        ((t_s / TICK_S).round().max(0.0) as usize).min(last)
    }

    /// The events of the phases that began before tick `first`, oldest first.
    pub(super) fn phases_before(&self, first: u64) -> impl Iterator<Item = EventInfo> + '_ {
        self.info.phases.iter().take_while(move |phase| phase.tick < first).cloned()
    }

    /// The tick at which a seek to `t_s` starts, and the number of ticks to fly before the target is shown. At least one tick is flown, so
    /// that there is a picture.
    pub(super) fn run_up(&self, t_s: f64) -> (usize, usize) {
        let target = self.tick_at(t_s);
        let first = target.saturating_sub(WARM_UP_TICKS);
        (first, target - first + 1)
    }
}

/// The event of a phase.
fn event(phase: &Knowledge) -> EventInfo {
    EventInfo {
        tick: phase.first as u64,
        t_s: phase.first as f64 * TICK_S,
        kind: EventKind::Phase,
        text: phase.text().to_owned(),
    }
}

/// Why `message` is refused in a mirrored (`mirrored`) or simulated flight; `None` if it is allowed.
pub(super) fn refusal(message: &ClientMessage, mirrored: bool) -> Option<&'static str> {
    match message {
        ClientMessage::Seek { .. } if !mirrored => Some(
            "seek refused: a simulated flight has no later part yet; restart it, or mirror its recording",
        ),
        _ if !mirrored => None,
        ClientMessage::Disturb { .. } => {
            Some("refused: this flight was flown already; nothing can be done to its vehicle")
        }
        ClientMessage::Fork { .. }
        | ClientMessage::NameFork { .. }
        | ClientMessage::DropFork { .. } => Some(
            "fork refused: the recorded vehicle cannot go on in another way; fork a simulated flight",
        ),
        ClientMessage::Preset { .. } => Some(
            "preset refused: the recorded vehicle flies its own controller; only the gains of the adapter are in force",
        ),
        ClientMessage::SetGain { name, .. } if !acts_in_shadow(name) => Some(
            "gain refused: the recorded vehicle flies its own controller; only the gains of the adapter are in force",
        ),
        ClientMessage::Restart { seed: Some(_), .. }
        | ClientMessage::Restart { scenario: Some(_), .. } => Some(
            "restart refused: a recording has no seed and no other scenario; allowed: restart without either, seek",
        ),
        _ => None,
    }
}

/// True for gains of the adapter: they change the prediction only.
pub(super) fn acts_in_shadow(name: &str) -> bool {
    let parameters = twin_core::tuning::Tuning::parameters();
    // An unknown name is refused with the list of names instead.
    parameters.iter().find(|known| known.name == name).is_none_or(|known| known.group == "Adapter")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> ClientMessage {
        serde_json::from_str(text).expect(text)
    }

    #[test]
    fn what_makes_no_sense_on_a_recording_is_refused_and_transport_is_not() {
        for (text, refused) in [
            (r#"{"type":"pause","paused":true}"#, false),
            (r#"{"type":"step","ticks":1}"#, false),
            (r#"{"type":"speed","value":20}"#, false),
            (r#"{"type":"seek","t_s":3.5}"#, false),
            (r#"{"type":"restart","seed":null,"scenario":null}"#, false),
            (r#"{"type":"restart","seed":3,"scenario":null}"#, true),
            (r#"{"type":"set_gain","name":"forgetting","value":0.98}"#, false),
            (r#"{"type":"set_gain","name":"slope.x","value":1}"#, true),
            (r#"{"type":"preset","name":"paper"}"#, true),
            (r#"{"type":"disturb","disturbance":{"kind":"drop_payload"}}"#, true),
        ] {
            assert_eq!(refusal(&message(text), true).is_some(), refused, "{text}");
            let only_seek = text.contains("seek");
            assert_eq!(refusal(&message(text), false).is_some(), only_seek, "{text}");
        }
    }
}
