//! State that the listening thread shares with the threads that read the flight: samples, clock, and news about the stream.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use mcap::records::{Channel, Record};

use super::super::container::Findings;
use super::super::effort::Effort;
use super::super::gather::{Gathered, MessageDecoder, Track};
use super::super::opened::{OpenedFlight, choose_map};
use super::super::recorded::on_ticks;
use super::super::signals::signals;
use super::super::survey::Survey;
use super::super::table::Definitions;
use super::super::topics::Map;
use super::super::vehicles::one;
use super::LOOK;
use super::pulse::Pulse;
use twin_input::budget::LIVE_SAMPLES;
use twin_input::work;

/// Time for which samples stay in memory, s.
const KEPT_S: f64 = 600.0;

/// Time of messages before the flight is judged for the first time, and between later judgements while the force is unknown, s.
const JUDGED_AFTER_S: f64 = 3.0;

/// Length of the newest part of the stream by which the flight is judged, ns.
const JUDGED_NS: u64 = 60_000_000_000;

/// Time without a message after which the stream counts as silent, s.
const SILENT_S: f64 = 0.2;

#[derive(Debug)]
pub(super) struct Shared {
    name: String,
    wanted_map: Option<String>,
    start: Instant,
    stop: AtomicBool,
    state: Mutex<StreamState>,
}

#[derive(Debug, Default)]
pub(super) struct StreamState {
    definitions: Definitions,
    counts: BTreeMap<u16, u64>,
    /// The first shipped map, in their order, that recognises a topic.
    family: Option<&'static str>,
    map: Option<(Arc<Map>, String)>,
    /// Number of maps that were chosen so far.
    maps: u64,
    collector: Option<MessageDecoder<Arc<Map>>>,
    /// Tracks by channel.
    tracks: BTreeMap<u16, Vec<Track>>,
    pub(super) pulse: Pulse,
    first_heard_s: Option<f64>,
    pruned_s: f64,
    /// Grows when more is known than at the last opening, or when a new flight begins.
    generation: u64,
    /// Time zero of the ticks, ns; it stays while the same flight goes on.
    start_ns: Option<i64>,
    judged_s: f64,
    effort_known: bool,
    up: bool,
    silent: bool,
    news: Vec<String>,
}

#[expect(clippy::disallowed_methods, reason = "the age of a stream is a wall-clock time")]
pub(super) fn wall() -> Instant {
    Instant::now()
}

impl Shared {
    /// The state of a stream called `name`; `map` names a map as for a recording.
    pub(super) fn new(name: String, map: Option<&str>) -> Self {
        Self {
            name,
            wanted_map: map.map(str::to_owned),
            start: wall(),
            stop: AtomicBool::new(false),
            state: Mutex::default(),
        }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// A counter that grows when more is known than before.
    pub(super) fn generation(&self) -> u64 {
        self.state().generation
    }

    /// What happened since the last call, one sentence each.
    pub(super) fn news(&self) -> Vec<String> {
        self.look();
        std::mem::take(&mut self.state().news)
    }

    /// True while messages arrive.
    pub(super) fn is_up(&self) -> bool {
        self.look();
        let state = self.state();
        state.up && !state.silent
    }

    pub(super) fn state(&self) -> MutexGuard<'_, StreamState> {
        // A thread that panicked left only whole samples behind.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn now_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Sleeps for `time`, or until a request to stop.
    pub(super) fn pause(&self, time: Duration) {
        let start = wall();
        while start.elapsed() < time && !self.is_stopped() {
            std::thread::sleep(LOOK.min(time));
        }
    }

    /// Notes that the stream is connected.
    pub(super) fn is_connected(&self) {
        let mut state = self.state();
        if !state.up {
            state.up = true;
            if state.start_ns.is_some() {
                state.news.push(format!("{}: connected again", self.name));
            }
        }
    }

    /// Notes that the stream is lost; the news report it once.
    pub(super) fn is_lost(&self, why: &str) {
        let mut state = self.state();
        if state.up || state.first_heard_s.is_none() && state.news.is_empty() {
            state.news.push(format!(
                "{}: connection lost: {why}; every value is unknown until the stream is connected again, which the program keeps trying",
                self.name
            ));
        }
        state.up = false;
    }

    /// Takes a record of the stream.
    pub(super) fn take(&self, record: Record<'_>) {
        let now_s = self.now_s();
        let mut state = self.state();
        let heard = match &record {
            Record::Message { header, .. } => {
                *state.counts.entry(header.channel_id).or_default() += 1;
                state.first_heard_s.get_or_insert(now_s);
                if state.silent {
                    state.silent = false;
                    state.news.push(format!("{}: messages arrive again", self.name));
                }
                if state.pulse.heard(header.log_time as f64 * 1e-9, now_s)
                    && state.start_ns.is_some()
                {
                    state.begin_anew();
                    state
                        .news
                        .push(format!("{}: its clock jumped; a new flight begins", self.name));
                }
                header.channel_id
            }
            Record::Channel(channel) => {
                let number = channel.id;
                if !state.definitions.channels.contains_key(&number) {
                    state.definitions.take(record.into_owned());
                    self.define(&mut state, number);
                }
                return;
            }
            Record::Schema { .. } => {
                state.definitions.take(record.into_owned());
                return;
            }
            _ => return,
        };
        if let Some(collector) = &mut state.collector {
            collector.take(record);
        }
        state.store(heard, now_s);
    }

    /// Takes a new channel: chooses the map by the topics that are known so far, and opens the channel with it.
    fn define(&self, state: &mut StreamState, number: u16) {
        let topic = state.definitions.channels.get(&number).map(|channel| channel.topic.as_str());
        let family = Map::detect(topic.as_slice());
        let better = Map::first_of(state.family, family);
        if state.map.is_none() || better != state.family {
            state.family = better;
            if let Ok((map, name)) = choose_map(self.wanted_map.as_deref(), better) {
                state.choose(Arc::new(map), name);
            }
        }
        state.open(number);
    }

    /// Number of maps that were chosen so far; a channel that no map asked for may be asked for by the next.
    pub(super) fn maps(&self) -> u64 {
        self.state().maps
    }

    /// Whether the map asks for a channel of this topic and schema.
    pub(super) fn wants(&self, channel: &Channel, schema: &str) -> bool {
        let state = self.state();
        let rule = state.map.as_ref().and_then(|(map, _)| map.rule(&channel.topic, schema));
        rule.is_some_and(|(_, rule)| !rule.gives.is_empty())
    }

    /// Notes when the stream becomes silent.
    fn look(&self) {
        let now_s = self.now_s();
        let mut state = self.state();
        let silent = state.up
            && state.first_heard_s.is_some()
            && state.pulse.silent_s(now_s) > SILENT_S + state.pulse.lag_s();
        if silent && !state.silent {
            state.silent = true;
            state.news.push(format!(
                "{}: the stream is silent; every value is unknown until the next message",
                self.name
            ));
        }
    }

    /// Whether messages have arrived for long enough to judge the flight.
    pub(super) fn is_ripe(&self) -> bool {
        let now_s = self.now_s();
        self.state().first_heard_s.is_some_and(|first_s| now_s - first_s > JUDGED_AFTER_S)
    }

    /// Judges the flight again from time to time while its force is unknown, and counts the generation up if the force is known
    /// now.
    pub(super) fn judge_again(&self) {
        let now_s = self.now_s();
        let mut state = self.state();
        let due = now_s - state.judged_s > JUDGED_AFTER_S && !state.silent;
        if !state.effort_known && due && state.start_ns.is_some() {
            state.judged_s = now_s;
            let gathered = state.gathered();
            let facts = state.map.as_ref().map(|(map, _)| map.vehicle.clone()).unwrap_or_default();
            drop(state);
            let found = one(gathered, &facts)
                .and_then(|(gathered, _)| on_ticks(&signals(&gathered), &facts));
            if found.is_ok_and(|flight| !matches!(flight.effort, Effort::Unknown { .. })) {
                self.state().generation += 1;
            }
        }
    }

    /// The last minute of the stream as a flight.
    pub(super) fn judged(&self) -> Option<OpenedFlight> {
        let (gathered, map, map_name, mut survey) = {
            let state = self.state();
            let (map, name) = state.map.clone()?;
            let survey = Survey::of_definitions(
                &state.definitions,
                &state.counts,
                (0, 0),
                Findings::default(),
            );
            (state.gathered(), map, name, survey)
        };
        survey.mark(&map);
        let (gathered, _) = one(gathered, &map.vehicle).ok()?;
        let mut signals = signals(&gathered);
        let recorded = on_ticks(&signals, &map.vehicle).ok()?;
        let mut state = self.state();
        state.effort_known = !matches!(recorded.effort, Effort::Unknown { .. });
        state.judged_s = self.now_s();
        signals.start_ns = *state.start_ns.get_or_insert(signals.start_ns);
        drop(state);
        Some(OpenedFlight {
            path: PathBuf::from(&self.name),
            survey,
            map: (*map).clone(),
            map_name,
            signals,
            vehicles: Vec::new(),
            recorded,
            long: None,
        })
    }
}

impl StreamState {
    /// The tracks in order of their channels.
    pub(super) fn tracks(&self) -> impl Iterator<Item = &Track> {
        self.tracks.values().flatten()
    }

    /// Decodes with `map` from now on, unless it is the map in use.
    fn choose(&mut self, map: Arc<Map>, name: String) {
        if self.map.as_ref().is_some_and(|(_, known)| *known == name) {
            return;
        }
        self.collector = Some(MessageDecoder::new(Arc::clone(&map), None));
        self.map = Some((map, name));
        self.maps += 1;
        self.tracks.clear();
        let numbers: Vec<u16> = self.definitions.channels.keys().copied().collect();
        for number in numbers {
            self.open(number);
        }
    }

    /// Opens a channel whose definition is known.
    fn open(&mut self, number: u16) {
        let Some(collector) = &mut self.collector else { return };
        self.definitions.records_of(number, &mut |record| collector.take(record));
        let tracks = collector.empty_tracks_of(number);
        if !tracks.is_empty() {
            self.tracks.entry(number).or_insert(tracks);
        }
    }

    /// Forgets the samples, because another flight began or the clock was set.
    fn begin_anew(&mut self) {
        self.tracks.values_mut().flatten().for_each(|track| track.samples.clear());
        (self.start_ns, self.effort_known) = (None, false);
        self.generation += 1;
    }

    /// Stores the decoded samples of a channel, and removes samples that are too old or too many.
    fn store(&mut self, channel: u16, now_s: f64) {
        let Some(collector) = &mut self.collector else { return };
        let samples = collector.drain_of(channel);
        let tracks = self.tracks.get_mut(&channel).map_or(&mut [][..], |tracks| tracks);
        for (track, samples) in tracks.iter_mut().zip(samples) {
            work::steps(1);
            track.samples.extend(samples);
            // An eighth is removed at once, so that each sample is moved a few times at most.
            let most = LIVE_SAMPLES.count();
            if track.samples.len() > most + most / 8 {
                track.samples.drain(..track.samples.len() - most);
            }
        }
        if now_s - self.pruned_s > 1.0 {
            self.pruned_s = now_s;
            let oldest = self.pulse.now_s(now_s).unwrap_or(0.0) - KEPT_S;
            for track in self.tracks.values_mut().flatten() {
                let old = track.samples.partition_point(|s| (s.log_ns as f64 * 1e-9) < oldest);
                track.samples.drain(..old);
            }
        }
    }

    /// The last minute of samples, by which the flight is judged.
    fn gathered(&self) -> Gathered {
        let newest = self.tracks().filter_map(|track| track.samples.last());
        let newest_ns = newest.map(|sample| sample.log_ns).max().unwrap_or(0);
        let from_ns = newest_ns.saturating_sub(JUDGED_NS);
        let late = |track: &Track| {
            let first = track.samples.partition_point(|sample| sample.log_ns < from_ns);
            Track { samples: track.samples[first..].to_vec(), ..track.bare() }
        };
        Gathered { tracks: self.tracks().map(late).collect(), notes: Vec::new() }
    }
}
