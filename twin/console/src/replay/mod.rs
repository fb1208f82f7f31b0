//! A recorded flight as one page that needs neither server nor network: the console's 3-D view, charts and events.
//!
//! In: a [`Recording`]. Out: HTML with script, style and flight inside. The page judges the ticks again by the scenario in the
//! recording, so it knows which demand failed first and opens there. State: none.

mod spectra;
mod frames;
mod broken;
mod assets;
mod viewers;

pub use viewers::{export_meshcat, export_viser};

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::server::channels::Channels;
use crate::server::protocol::{
    EventInfo, FlightPhase, Hello, PROTOCOL_VERSION, PresetName, StateInfo,
};
use twin_core::notation::TICK_S;
use twin_core::residual::PredictorInfo;
use twin_core::tick::Tick;
use twin_core::tuning::Tuning;
use twin_input::interruption;
use twin_record::scene::Scene;
use twin_record::{PER_KILOGRAM, Recording, RecordingError, read_recording};
use twin_scenario::file::read_recorded;
use twin_scenario::{ActuatorLimits, Assessor, DEFAULTS, Report, Scenario, Settings};

/// Identifier that links the telemetry rows to the channels. A page has only one flight, so one identifier is enough.
const SCHEMA_ID: u16 = 1;

/// Why a page cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording lacks what the page needs.
    #[error("the recording has no usable {part}: {why}; record the flight again with this version")]
    Part {
        /// Name of the attachment or metadata.
        part: &'static str,
        /// The reason why the part is unusable.
        why: String,
    },
    /// This program was built without the console.
    #[error(
        "this program was built without the console, whose parts the page needs; install npm and build it again with the feature web"
    )]
    NoConsole,
    /// The files of the stock viewer, which become part of the page, are missing.
    #[error("{}: cannot read the stock viewer: {why}; run `twin viewers fetch` once, or give its folder as --viewer-dir", .path.display())]
    NoViewer {
        /// The file.
        path: PathBuf,
        /// The reason why the file is unusable.
        why: String,
    },
    /// The flight cannot be packed.
    #[error("cannot pack the flight: {0}")]
    Pack(#[from] std::io::Error),
}

/// A demand of the scenario that the flight did not meet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    /// Time of the flight from which on the demand could no longer be met, s.
    pub at_s: f64,
    /// One sentence: the demand, the value found and the value allowed.
    pub text: String,
    /// Names of the channels that show it: the signal, then its limits; none if the demand limits no number of a tick.
    pub channels: Vec<String>,
}

/// The description of the flight, which `web/src/replay/flight.ts` reads.
#[derive(Serialize)]
struct Head {
    hello: Hello,
    title: String,
    seed: u64,
    verdict: String,
    reason: String,
    state_hash: String,
    program: String,
    passed: Option<bool>,
    failures: Vec<Failure>,
    opens_at_s: f64,
}

/// The page of the recording at `from`, and the time at which the page opens, s. Without a `report` of the flight this function judges
/// the flight again, but not against a golden run, because a recording contains none.
///
/// # Errors
/// [`ReplayError`] if the recording is not usable, or a signal asks the program to end.
pub fn export(from: &Path, report: Option<&Report>) -> Result<(String, f64), ReplayError> {
    let page = page(&read_recording(from)?, report)?;
    interruption::check().map_err(RecordingError::from)?;
    Ok(page)
}

/// The page of a flight, and the time at which it opens, s: the first failure, or the start if nothing failed.
///
/// # Errors
/// [`ReplayError`] if the recording lacks a part.
pub fn page(recording: &Recording, report: Option<&Report>) -> Result<(String, f64), ReplayError> {
    let scene: Scene = json_part(recording.attachments.get("scene.json"), "scene.json")?;
    let gains = recording.metadata.get("gains").map(String::as_bytes);
    let tuning: Tuning = json_part(gains, "gains")?;
    let mirrored = recording.is_mirrored();
    let scenario = if mirrored { of_recording(recording)? } else { scenario(recording)? };
    // No scenario makes demands on a mirrored flight.
    let judged = || (!mirrored).then(|| judged(&scenario, &recording.ticks)).flatten();
    let report = report.cloned().or_else(judged);
    let mut channels = channels(recording, scene.rotors.len())?;
    let failures = failures(report.as_ref(), &scenario.settings, &mut channels);
    let flown = frames::frames(&scene, &channels, &tuning, &recording.ticks);
    let head = head(recording, &scenario, report, failures, (scene, &channels));
    let opens_at_s = head.opens_at_s;
    let head = serde_json::to_vec(&head).map_err(std::io::Error::from)?;
    let flight = frames::packed(&head, &flown)?;
    Ok((assets::filled(&scenario.name, &flight)?, opens_at_s))
}

/// The channels of the flight.
fn channels(recording: &Recording, rotors: usize) -> Result<Channels, ReplayError> {
    // A recording without information about the predictor is old; its predictor had no network.
    let predictor = recording.metadata.get("predictor").map(String::as_str).unwrap_or_default();
    let predictor: PredictorInfo = serde_json::from_str(predictor).unwrap_or_default();
    let channels = if recording.is_mirrored() {
        Channels::mirrored(rotors, &predictor.scale)
            .per_kilogram(recording.metadata.contains_key(PER_KILOGRAM))
    } else {
        let limits = recording.metadata.get("actuator_limits").map(String::as_bytes);
        let limits: ActuatorLimits = json_part(limits, "actuator_limits")?;
        Channels::new(rotors, &limits, &predictor)
    };
    Ok(channels.with_weight(weight(recording)))
}

/// Weight of the vehicle, in the unit of its forces: the simulation knows it, and of a real vehicle it is the forecast of its predictor.
/// `None` if the recording has neither.
fn weight(recording: &Recording) -> Option<f64> {
    let of_budget = |tick: &Tick| Some(tick.truth.as_ref()?.budget.as_ref()?.gravity.z.abs());
    let of_forecast = |tick: &Tick| tick.forecast.base.first()?.get(2);
    let mut ticks = recording.ticks.iter();
    if recording.is_mirrored() { ticks.find_map(of_forecast) } else { ticks.find_map(of_budget) }
}

/// The demands that the flight did not meet, earliest first. Their signals and limits become channels.
fn failures(report: Option<&Report>, settings: &Settings, channels: &mut Channels) -> Vec<Failure> {
    let broken = report.into_iter().flat_map(|report| &report.broken);
    let failure = |broken: &twin_scenario::Violation| Failure {
        at_s: broken.at_s,
        text: broken.to_string(),
        channels: broken::channels_of(broken, settings, channels),
    };
    let mut failures: Vec<Failure> = broken.map(failure).collect();
    failures.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    failures
}

fn json_part<T: serde::de::DeserializeOwned>(
    bytes: Option<impl AsRef<[u8]>>,
    part: &'static str,
) -> Result<T, ReplayError> {
    let bytes = bytes.ok_or(ReplayError::Part { part, why: "it is missing".to_owned() })?;
    serde_json::from_slice(bytes.as_ref())
        .map_err(|error| ReplayError::Part { part, why: error.to_string() })
}

/// The scenario of a mirrored flight: the recording gives only its name.
fn of_recording(recording: &Recording) -> Result<Scenario, ReplayError> {
    let name = recording.metadata.get("scenario").cloned().unwrap_or_default();
    Scenario::of_recording(&name, &PathBuf::from(&name))
        .map_err(|error| ReplayError::Part { part: "scenario", why: error.to_string() })
}

/// The scenario as it was flown, every default and override resolved.
fn scenario(recording: &Recording) -> Result<Scenario, ReplayError> {
    let part = "scenario.toml";
    let refused = |why: String| ReplayError::Part { part, why };
    let bytes =
        recording.attachments.get(part).ok_or_else(|| refused("it is missing".to_owned()))?;
    let text = std::str::from_utf8(bytes).map_err(|error| refused(error.to_string()))?;
    let name = recording.metadata.get("scenario").cloned().unwrap_or_default();
    let mut settings: Settings = read_recorded(text, Path::new(part), DEFAULTS)
        .map_err(|error| refused(error.to_string()))?;
    settings.golden = None;
    Ok(Scenario { file: PathBuf::from(&name).with_extension("toml"), name, settings })
}

/// The report of the flight; `None` if its last tick is missing.
fn judged(scenario: &Scenario, ticks: &[Tick]) -> Option<Report> {
    let mut assessor = Assessor::new(scenario);
    let end = ticks.iter().find_map(|tick| assessor.add(tick))?;
    Some(assessor.finish(end, 0))
}

fn head(
    recording: &Recording,
    scenario: &Scenario,
    report: Option<Report>,
    failures: Vec<Failure>,
    (scene, channels): (Scene, &Channels),
) -> Head {
    let said = |key: &str| recording.metadata.get(key).cloned().unwrap_or_default();
    let cut = || match recording.metadata.get("verdict") {
        Some(verdict) if recording.is_mirrored() => (verdict.clone(), String::new()),
        _ => ("unfinished".to_owned(), "the recording has no end".to_owned()),
    };
    let (verdict, reason) =
        report.as_ref().map_or_else(cut, |r| (r.verdict.to_string(), r.reason.clone()));
    let start_s = recording.ticks.first().map_or(0.0, |tick| tick.measurement.t_s);
    let hello = hello(scenario, scene, channels, &recording.ticks, (&verdict, &reason));
    Head {
        hello,
        title: scenario.settings.title.clone(),
        seed: scenario.settings.seed,
        state_hash: said("state_hash"),
        program: format!("twin {} {}", said("version"), said("git")),
        passed: report.map(|report| report.passed),
        opens_at_s: failures.first().map_or(start_s, |failure| failure.at_s),
        verdict,
        reason,
        failures,
    }
}

fn hello(
    scenario: &Scenario,
    scene: Scene,
    channels: &Channels,
    ticks: &[Tick],
    (verdict, reason): (&str, &str),
) -> Hello {
    let settings = &scenario.settings;
    let last = ticks.last();
    let state = StateInfo {
        phase: FlightPhase::Ended,
        speed: None,
        scenario: scenario.name.clone(),
        seed: settings.seed,
        tick: last.map_or(0, |tick| tick.index + 1),
        t_s: last.map_or(0.0, |tick| tick.measurement.t_s),
        task_phase: last.map_or_else(String::new, |tick| tick.phase.clone()),
        verdict: Some(verdict.to_owned()),
        reason: Some(reason.to_owned()),
        real_time_factor: 0.0,
        clients: 0,
        stages: Vec::new(),
        payload_kg: (settings.payload.mass_kg > 0.0).then_some(settings.payload.mass_kg),
        wind_m_s: settings.wind.velocity_m_s,
        effects_off: Vec::new(),
        twin: None,
        recording: None,
    };
    Hello {
        protocol: PROTOCOL_VERSION,
        schema_id: SCHEMA_ID,
        client_id: 0,
        scenario: scenario.name.clone(),
        scenarios: Vec::new(),
        tick_s: TICK_S,
        horizon_ticks: ticks.iter().map(|tick| tick.forecast.base.len()).max().unwrap_or(1) as u32
            - 1,
        mirror: None,
        quantities: Vec::new(),
        effects: Vec::new(),
        scene,
        channels: channels.infos().to_vec(),
        gains: Vec::new(),
        preset: PresetName::Custom,
        state,
        events: ticks.iter().flat_map(events).collect(),
        forks: Vec::new(),
    }
}

fn events(tick: &Tick) -> impl Iterator<Item = EventInfo> + '_ {
    tick.events.iter().map(|event| EventInfo {
        tick: tick.index,
        t_s: tick.measurement.t_s,
        kind: event.kind,
        text: event.text.clone(),
    })
}

/// Fills `markers` of `template`, each found once and in this order.
fn fill(template: &str, parts: &[(&str, &str)]) -> Option<String> {
    let mut page = String::new();
    let mut rest = template;
    for (marker, text) in parts {
        let (before, after) = rest.split_once(marker)?;
        page.push_str(before);
        page.push_str(text);
        rest = after;
    }
    page.push_str(rest);
    Some(page)
}

/// The parts of the page by name, as the build script packed them.
type Assets = BTreeMap<&'static str, String>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_are_filled_in_order_and_what_is_put_in_is_not_searched_again() {
        let parts = [("/*a*/", "1 /*b*/"), ("/*b*/", "2")];
        assert_eq!(fill("x /*a*/ y /*b*/ z", &parts).unwrap(), "x 1 /*b*/ y 2 z");
        assert_eq!(fill("x /*a*/", &parts), None);
    }
}
