//! Decodes the messages that a map asks for into samples of quantities, each with its log time and its stamp.
//!
//! In: a recording and a [`Map`]. Out: one [`Track`] per channel and quantity.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::ops::Deref;
use std::sync::Arc;

use mcap::records::Record;

use super::container::{self, ContainerError};
use super::form::{Form, Forms};
use super::message_definitions::MessageDefinitions;
use super::topics::{Fields, Map, Quantity, Rule, TimeSource};
use super::value::{Path, Value};
use twin_input::{Reader, work};

/// The numbers of one message in SI units, in the axes of its topic.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Log time, ns.
    pub log_ns: u64,
    /// Stamp of the measurement on the message's own clock, ns, if the message has one.
    pub stamp_ns: Option<i64>,
    /// The numbers.
    pub values: Vec<f64>,
}

/// One quantity of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Number of the channel.
    pub channel: u16,
    /// Topic of the channel.
    pub topic: String,
    /// Name of the schema.
    pub schema: String,
    /// Number of the rule in the map; a smaller number is a better source.
    pub rank: usize,
    /// The rule that gives the quantity.
    pub rule: Rule,
    /// The quantity that the numbers mean.
    pub quantity: Quantity,
    /// Names of the joints, if the quantity is joint angles.
    pub names: Vec<String>,
    /// Samples in file order.
    pub samples: Vec<Sample>,
}

impl Track {
    /// Whether any number is finite and not zero. Flags are alive at any value.
    pub(super) fn is_alive(&self) -> bool {
        let flag = matches!(self.quantity, Quantity::Landed | Quantity::Armed | Quantity::Resets);
        let moves = |v: &f64| v.is_finite() && *v != 0.0;
        flag || self.samples.iter().any(|sample| sample.values.iter().any(moves))
    }

    /// A copy of the track without its samples.
    pub(super) fn bare(&self) -> Self {
        work::steps(1);
        Self {
            topic: self.topic.clone(),
            schema: self.schema.clone(),
            rule: self.rule.clone(),
            names: self.names.clone(),
            samples: Vec::new(),
            ..*self
        }
    }
}

/// All tracks of a recording, and the messages that could not be decoded.
#[derive(Clone, Debug, Default)]
pub struct Gathered {
    /// Tracks in order of topic.
    pub tracks: Vec<Track>,
    /// What could not be decoded, one sentence per channel.
    pub notes: Vec<String>,
}

/// Reads the quantities that `map` asks for from `file`.
///
/// # Errors
/// [`ContainerError`] if the file cannot be read.
pub fn gather(file: &std::path::Path, map: &Map) -> Result<Gathered, ContainerError> {
    gather_from(&mut Reader::open(file)?, map)
}

/// Reads the quantities that `map` asks for from any input.
///
/// # Errors
/// [`ContainerError`] if the input cannot be read.
pub fn gather_from(input: &mut impl Read, map: &Map) -> Result<Gathered, ContainerError> {
    let mut collector = MessageDecoder::new(map, None);
    container::read(input, &mut |record| collector.take(record))?;
    Ok(collector.finish())
}

#[derive(Debug)]
struct Channel {
    form: Arc<Form>,
    topic: String,
    time: Option<(bool, Path)>,
    quantities: Vec<Extract>,
    tracks: Vec<Track>,
    undecodable: u64,
    first_error: String,
}

#[derive(Debug)]
struct Extract {
    quantity: Quantity,
    paths: Vec<Path>,
    fields: Fields,
    only_if: Option<(Path, Vec<f64>)>,
}

/// Decodes records as they arrive; `M` is a map or a reference to a map.
#[derive(Debug)]
pub(super) struct MessageDecoder<M> {
    map: M,
    /// The only channels to decode, if given.
    only: Option<BTreeSet<u16>>,
    schemas: MessageDefinitions,
    forms: Forms,
    channels: BTreeMap<u16, Channel>,
    /// Channels that cannot be decoded: the summary of a file defines its channels a second time.
    refused: BTreeSet<u16>,
    notes: Vec<String>,
}

impl<M: Deref<Target = Map>> MessageDecoder<M> {
    /// A collector for all channels that `map` asks for, restricted to `only` if given.
    pub(super) fn new(map: M, only: Option<BTreeSet<u16>>) -> Self {
        Self {
            map,
            only,
            schemas: MessageDefinitions::default(),
            forms: Forms::default(),
            channels: BTreeMap::new(),
            refused: BTreeSet::new(),
            notes: Vec::new(),
        }
    }

    pub(super) fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                let number = header.id;
                if self.schemas.take(header, &data) {
                    self.forms.forget(number);
                }
            }
            Record::Channel(channel) => self.open(&channel),
            Record::Message { header, data } => {
                if let Some(channel) = self.channels.get_mut(&header.channel_id) {
                    channel.message(header.log_time, &data, &self.map.vehicle.joints);
                }
            }
            _ => {}
        }
    }

    /// The tracks without their samples, in the order of [`Self::drain`].
    pub(super) fn empty_tracks(&self) -> Vec<Track> {
        let tracks = self.channels.values().flat_map(|channel| &channel.tracks);
        tracks.map(Track::bare).collect()
    }

    /// The tracks of one channel without their samples.
    pub(super) fn empty_tracks_of(&self, channel: u16) -> Vec<Track> {
        let tracks = self.channels.get(&channel).map_or(&[][..], |channel| &channel.tracks);
        tracks.iter().map(Track::bare).collect()
    }

    /// Removes and returns the samples of one channel since the last call, per track.
    pub(super) fn drain_of(&mut self, channel: u16) -> Vec<Vec<Sample>> {
        let tracks = self.channels.get_mut(&channel).map_or(&mut [][..], |c| &mut c.tracks);
        tracks.iter_mut().map(|track| std::mem::take(&mut track.samples)).collect()
    }

    /// Removes and returns the samples since the last call, per track.
    pub(super) fn drain(&mut self) -> Vec<Vec<Sample>> {
        let tracks = self.channels.values_mut().flat_map(|channel| &mut channel.tracks);
        tracks.map(|track| std::mem::take(&mut track.samples)).collect()
    }

    /// What could not be decoded since the last call, one sentence per channel.
    pub(super) fn complaints(&mut self) -> Vec<String> {
        self.channels.values_mut().filter_map(Channel::complaint).collect()
    }

    fn open(&mut self, channel: &mcap::records::Channel) {
        work::steps(1);
        let unwanted = self.only.as_ref().is_some_and(|only| !only.contains(&channel.id));
        let known = self.channels.contains_key(&channel.id) || self.refused.contains(&channel.id);
        if unwanted || known {
            return;
        }
        let schema = self.schemas.get(channel.schema_id);
        let name = schema.map_or("", |schema| &schema.header.name);
        let definition = schema.and_then(|schema| schema.text.as_deref().ok()).unwrap_or_default();
        let Some((rank, rule)) = self.map.rule_for(&channel.topic, name, definition) else {
            return;
        };
        if rule.gives.is_empty() {
            return;
        }
        let form = self.forms.of(&self.schemas, channel);
        match form.and_then(|form| Channel::new(form, channel, name, (rank, rule))) {
            Ok(opened) => {
                self.channels.insert(channel.id, opened);
            }
            Err(why) => {
                self.refused.insert(channel.id);
                self.notes.push(format!("{}: {why}", channel.topic));
            }
        }
    }

    /// All tracks with their samples, and all complaints.
    pub(super) fn finish(mut self) -> Gathered {
        let complaints = self.complaints();
        let notes = [self.notes, complaints].concat();
        Gathered { tracks: self.channels.into_values().flat_map(|c| c.tracks).collect(), notes }
    }
}

impl Channel {
    fn new(
        form: Arc<Form>,
        channel: &mcap::records::Channel,
        schema: &str,
        (rank, rule): (usize, &Rule),
    ) -> Result<Self, String> {
        let time = match &rule.time {
            TimeSource::Log => None,
            TimeSource::Stamp { path } => Some((true, Path::parse(path)?)),
            TimeSource::Microseconds { path } => Some((false, Path::parse(path)?)),
        };
        let extract = |(quantity, fields): (&Quantity, &Fields)| {
            let paths = fields.paths.iter().map(|path| Path::parse(path)).collect::<Result<_, _>>();
            let only_if = match &fields.only_if {
                None => None,
                Some(condition) => Some((Path::parse(&condition.path)?, condition.is.clone())),
            };
            Ok(Extract { quantity: *quantity, paths: paths?, fields: fields.clone(), only_if })
        };
        let track = |quantity: &Quantity| Track {
            channel: channel.id,
            topic: channel.topic.clone(),
            schema: schema.to_owned(),
            rank,
            rule: rule.clone(),
            quantity: *quantity,
            names: Vec::new(),
            samples: Vec::new(),
        };
        Ok(Self {
            form,
            topic: channel.topic.clone(),
            time,
            quantities: rule.gives.iter().map(extract).collect::<Result<_, String>>()?,
            tracks: rule.gives.keys().map(track).collect(),
            undecodable: 0,
            first_error: String::new(),
        })
    }

    fn complaint(&mut self) -> Option<String> {
        let undecodable = std::mem::take(&mut self.undecodable);
        let first = std::mem::take(&mut self.first_error);
        (undecodable > 0).then(|| {
            format!("{}: {undecodable} messages could not be decoded: {first}", self.topic)
        })
    }

    fn message(&mut self, log_ns: u64, data: &[u8], joints: &[String]) {
        let value = self.form.decode(data);
        match value {
            Ok(value) => {
                let stamp_ns = self.time.as_ref().and_then(|time| stamp(&value, time));
                for (extract, track) in self.quantities.iter().zip(&mut self.tracks) {
                    if let Some(values) = extract.values(&value, joints, &mut track.names) {
                        track.samples.push(Sample { log_ns, stamp_ns, values });
                    }
                }
            }
            Err(why) => {
                self.undecodable += 1;
                if self.first_error.is_empty() {
                    self.first_error = why;
                }
            }
        }
    }
}

/// Stamp of a message, ns; `None` for a zero stamp, which nobody filled in.
fn stamp(value: &Value, (is_stamp, path): &(bool, Path)) -> Option<i64> {
    let ns = if *is_stamp {
        let stamp = value.at(path)?;
        let part = |name: &str| stamp.number(&Path::parse(name).ok()?);
        // Field names in ROS 2 and in the JSON of Foxglove and ROS 1, then in protobuf.
        (part("sec").or_else(|| part("seconds"))? as i64).checked_mul(1_000_000_000)?.checked_add(
            part("nanosec").or_else(|| part("nsec")).or_else(|| part("nanos"))? as i64,
        )?
    } else {
        (value.number(path)? as i64).checked_mul(1000)?
    };
    (ns != 0).then_some(ns)
}

impl Extract {
    fn values(
        &self,
        value: &Value,
        joints: &[String],
        names: &mut Vec<String>,
    ) -> Option<Vec<f64>> {
        if let Some((path, allowed)) = &self.only_if
            && !allowed.contains(&value.number(path)?)
        {
            return None;
        }
        let raw = match self.quantity {
            Quantity::Joints => joint_angles(
                value.at(self.paths.first()?)?,
                value.at(self.paths.get(1)?)?,
                joints,
                names,
            )?,
            Quantity::Motors => self
                .paths
                .iter()
                .flat_map(|path| match value.number(path) {
                    Some(number) => vec![number],
                    None => value.at(path).map(Value::numbers).unwrap_or_default(),
                })
                .filter(|output| output.is_finite())
                .collect(),
            _ => self.paths.iter().map(|path| value.number(path)).collect::<Option<Vec<f64>>>()?,
        };
        let factor = self.fields.factor();
        let scaled = raw.iter().enumerate().map(|(i, number)| {
            let scale = self.fields.scale.get(i).copied().unwrap_or(1.0);
            let number = number * factor * scale + self.fields.offset;
            match self.fields.clip {
                Some([low, high]) if number.is_finite() => number.max(low).min(high),
                _ => number,
            }
        });
        Some(scaled.collect())
    }
}

/// Angles of the two joints that have a coordinate; the first message fills `names`.
fn joint_angles(
    names_found: &Value,
    angles: &Value,
    wanted: &[String],
    names: &mut Vec<String>,
) -> Option<Vec<f64>> {
    let found = names_found.texts();
    if names.is_empty() {
        let chosen: Vec<String> = if wanted.is_empty() {
            found.iter().map(|name| (*name).to_owned()).collect()
        } else {
            wanted.to_vec()
        };
        *names = chosen.into_iter().take(2).collect();
    }
    let angles = angles.numbers();
    let one = |name: &String| angles.get(found.iter().position(|known| known == name)?).copied();
    let both = names.iter().map(one).collect::<Option<Vec<f64>>>()?;
    (!both.is_empty()).then_some(both)
}
