//! The contents of a recording without decoding a message: channels, schemas, counts, rates, gaps and damage.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Read;
use std::path::Path;

use mcap::records::{MessageHeader, Record};
use serde::Serialize;

use super::container::{self, ContainerError, Findings};
use super::index::Index;
use super::message_definitions::{MessageDefinition, MessageDefinitions};
use super::table::Definitions;
use super::topics::{Map, Quantity};
use twin_input::{Excess, Reader};

/// One channel of a recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ChannelInfo {
    /// Topic.
    pub topic: String,
    /// Name of the schema; empty if the channel has none.
    pub schema: String,
    /// Encodings of schema and message.
    pub encoding: String,
    /// Number of messages.
    pub messages: u64,
    /// Mean number of messages per second of log time, Hz.
    pub rate_hz: f64,
    /// Longest time between two messages, s; NaN if not every message was read.
    pub longest_gap_s: f64,
    /// Log time of the first message, s since the epoch of the recorder.
    pub first_s: f64,
    /// Log time of the last message, s since the epoch of the recorder.
    pub last_s: f64,
    /// Number of messages that were logged earlier than the message before.
    pub backwards: u64,
    /// Quantities that the map reads from the channel.
    pub gives: Vec<Quantity>,
}

/// The contents of a recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Survey {
    /// The container and its problems.
    pub container: Findings,
    /// Number of messages of all channels.
    pub messages: u64,
    /// Log time of the first message, s since the epoch of the recorder.
    pub start_s: f64,
    /// Time from the first to the last message, s.
    pub duration_s: f64,
    /// Name of the shipped map for this recording, if its family is recognised.
    pub family: Option<&'static str>,
    /// Channels in order of topic, also those without a message.
    pub channels: Vec<ChannelInfo>,
    /// Names of schemas that have more than one definition.
    pub ambiguous_schemas: Vec<String>,
}

const NS: f64 = 1e-9;

#[derive(Default)]
struct MessageCounter {
    schemas: MessageDefinitions,
    /// Hashes of the definitions of each schema.
    definitions: BTreeMap<String, BTreeSet<u64>>,
    /// Schemas whose definition the budget refuses, with the reason.
    refused: BTreeMap<String, Excess>,
    channels: BTreeMap<u16, (ChannelInfo, Option<u64>)>,
    orphans: u64,
}

impl MessageCounter {
    fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                let number = header.id;
                if !self.schemas.take(header, &data) {
                    return;
                }
                let Some(MessageDefinition { header, text }) = self.schemas.get(number) else {
                    return;
                };
                match text {
                    Ok(text) => {
                        let mut hash = DefaultHasher::new();
                        text.hash(&mut hash);
                        let known = self.definitions.entry(header.name.clone()).or_default();
                        known.insert(hash.finish());
                    }
                    Err(excess) => {
                        self.refused.insert(header.name.clone(), *excess);
                    }
                }
            }
            Record::Channel(channel) => {
                let header = self.schemas.get(channel.schema_id).map(|known| known.header.clone());
                let (schema, encoding) =
                    header.map_or_else(Default::default, |h| (h.name, h.encoding));
                let info = ChannelInfo {
                    topic: channel.topic,
                    schema,
                    encoding: format!("{encoding}/{}", channel.message_encoding),
                    ..ChannelInfo::default()
                };
                self.channels.entry(channel.id).or_insert((info, None));
            }
            Record::Message { header, .. } => self.message(&header),
            _ => {}
        }
    }

    fn message(&mut self, header: &MessageHeader) {
        let Some((info, last)) = self.channels.get_mut(&header.channel_id) else {
            self.orphans += 1;
            return;
        };
        let t_s = header.log_time as f64 * NS;
        info.messages += 1;
        match *last {
            None => (info.first_s, info.last_s) = (t_s, t_s),
            Some(last) if header.log_time < last => info.backwards += 1,
            Some(last) => {
                let gap_s = (header.log_time - last) as f64 * NS;
                info.longest_gap_s = info.longest_gap_s.max(gap_s);
            }
        }
        info.first_s = info.first_s.min(t_s);
        info.last_s = info.last_s.max(t_s);
        *last = Some(header.log_time);
    }
}

impl Survey {
    /// Reads the recording in `file`.
    ///
    /// # Errors
    /// [`ContainerError`] if the file cannot be read.
    pub fn read(file: &Path) -> Result<Self, ContainerError> {
        Self::read_from(&mut Reader::open(file)?)
    }

    /// Reads the recording in `input`.
    ///
    /// # Errors
    /// [`ContainerError`] if the input cannot be read.
    pub fn read_from(input: &mut impl Read) -> Result<Self, ContainerError> {
        let mut collector = MessageCounter::default();
        let container = container::read(input, &mut |record| collector.take(record))?;
        Ok(Self::new(container, collector))
    }

    /// The survey from the index of a file: message counts per channel, and for all channels the time span of the whole file.
    pub(super) fn of_index(index: &Index) -> Self {
        let span_ns = index.span_ns().unwrap_or((0, 0));
        let (definitions, counts) = (&index.table.definitions, &index.table.counts);
        Self::of_definitions(definitions, counts, span_ns, index.table.findings.clone())
    }

    /// The survey from definitions and message counts per channel.
    pub(super) fn of_definitions(
        definitions: &Definitions,
        counts: &BTreeMap<u16, u64>,
        (first_ns, last_ns): (u64, u64),
        findings: Findings,
    ) -> Self {
        let mut collector = MessageCounter::default();
        definitions.records(&mut |record| collector.take(record));
        for definition in definitions.schemas.all() {
            if let Err(excess) = definition.text {
                collector.refused.insert(definition.header.name.clone(), excess);
            }
        }
        for (number, (info, _)) in &mut collector.channels {
            info.messages = counts.get(number).copied().unwrap_or(0);
            (info.first_s, info.last_s) = (first_ns as f64 * NS, last_ns as f64 * NS);
            info.longest_gap_s = f64::NAN;
        }
        Self::new(findings, collector)
    }

    fn new(mut container: Findings, collector: MessageCounter) -> Self {
        if collector.orphans > 0 {
            let text = format!("{} messages belong to no known channel", collector.orphans);
            container.problem(text);
        }
        for (name, excess) in &collector.refused {
            container.problem(format!("schema {name:?}: {excess}"));
        }
        let mut channels: Vec<ChannelInfo> =
            collector.channels.into_values().map(|(info, _)| info).collect();
        for info in &mut channels {
            let span_s = info.last_s - info.first_s;
            if info.messages > 1 && span_s > 0.0 {
                info.rate_hz = (info.messages - 1) as f64 / span_s;
            }
        }
        channels.sort_by(|a, b| a.topic.cmp(&b.topic));
        let filled = || channels.iter().filter(|info| info.messages > 0);
        let start_s = filled().map(|info| info.first_s).fold(f64::MAX, f64::min);
        let end_s = filled().map(|info| info.last_s).fold(f64::MIN, f64::max);
        let topics: Vec<&str> = channels.iter().map(|info| info.topic.as_str()).collect();
        let family = Map::detect(&topics);
        Self {
            messages: filled().map(|info| info.messages).sum(),
            duration_s: (end_s - start_s).max(0.0),
            start_s: if end_s < start_s { 0.0 } else { start_s },
            family,
            ambiguous_schemas: collector
                .definitions
                .into_iter()
                .filter(|(_, texts)| texts.len() > 1)
                .map(|(name, _)| name)
                .collect(),
            channels,
            container,
        }
    }

    /// Whether `topic` has messages.
    pub fn has(&self, topic: &str) -> bool {
        self.channels.iter().any(|info| info.topic == topic && info.messages > 0)
    }

    /// At most `most` topics that have messages, as text for an error.
    pub fn topics(&self, most: usize) -> String {
        let filled = self.channels.iter().filter(|info| info.messages > 0).take(most);
        let named: Vec<String> =
            filled.map(|info| format!("{} ({})", info.topic, info.schema)).collect();
        if named.is_empty() { "none".to_owned() } else { named.join(", ") }
    }

    /// Notes for every channel which quantities `map` reads from it.
    pub fn mark(&mut self, map: &Map) {
        for info in &mut self.channels {
            if let Some((_, rule)) = map.rule(&info.topic, &info.schema) {
                info.gives = rule.gives.keys().copied().collect();
            }
        }
    }
}
