//! The layout of a recording: channels, schemas, attachments and metadata, in the order in which they are written.

use std::collections::BTreeMap;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::sync::Arc;

use foxglove::Encode;
use foxglove::messages::{FrameTransforms, JointStates, Log, SceneUpdate};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, WriteOptions, Writer};

use crate::output::RecordingFile;
use crate::progress::Progress;
use crate::recording::{
    MEASUREMENT_TOPIC, METADATA_END, METADATA_START, RecordingError, TICK_TOPIC,
};
use crate::recording_info::{RecordingEnd, RecordingInfo};
use crate::scene::Scene;
use crate::views;
use crate::watched_file::WatchedFile;
use twin_core::tick::Tick;

/// Period in ticks at which all bodies are drawn again, so that a viewer that seeks shows them within a second.
const BODIES_PERIOD_TICKS: u64 = 100;

/// Period in ticks at which contact arrows are drawn.
const CONTACTS_PERIOD_TICKS: u64 = 5;

/// JSON schema of the two lossless channels. Their fields are those of the records in `tick.rs`.
const ANY_OBJECT: &str = r#"{"type":"object","additionalProperties":true}"#;

struct Channels {
    transforms: u16,
    scene: u16,
    joints: u16,
    log: u16,
    tick: u16,
    measurement: u16,
}

/// The MCAP file that is open for writing.
pub(super) struct TrackWriter {
    path: PathBuf,
    file: Writer<BufWriter<WatchedFile>>,
    channels: Channels,
    scene: Scene,
    joint_names: Vec<String>,
    scratch: Vec<u8>,
    ticks: u64,
    progress: Arc<Progress>,
}

impl TrackWriter {
    pub(super) fn start(
        file: RecordingFile,
        info: &RecordingInfo,
        progress: Arc<Progress>,
    ) -> Result<Self, RecordingError> {
        let (path, file) = file.into_parts();
        let cause = Arc::clone(&progress);
        let failed = |error: &dyn std::fmt::Display| {
            RecordingError::create(&path, cause.cause().unwrap_or_else(|| error.to_string()))
        };
        let file = WatchedFile::new(file, Arc::clone(&progress));
        let mut file = WriteOptions::new()
            .profile("")
            .compression_threads(0)
            .create(BufWriter::new(file))
            .map_err(|e| failed(&e))?;
        let scene = serde_json::to_string(&info.scene).map_err(|e| failed(&e))?;
        for (name, media_type, text) in [
            ("vehicle.urdf", "application/xml", &info.urdf),
            ("scenario.toml", "application/toml", &info.scenario_toml),
            ("scene.json", "application/json", &scene),
        ] {
            if text.is_empty() {
                continue;
            }
            let attachment = Attachment {
                log_time: 0,
                create_time: 0,
                name: name.to_owned(),
                media_type: media_type.to_owned(),
                data: text.as_bytes().into(),
            };
            file.attach(&attachment).map_err(|e| failed(&e))?;
        }
        file.write_metadata(&Metadata {
            name: METADATA_START.to_owned(),
            metadata: info.metadata(),
        })
        .map_err(|e| failed(&e))?;
        let channels = add_channels(&mut file).map_err(|e| failed(&e))?;
        file.flush().map_err(|e| failed(&e))?;
        Ok(Self {
            path,
            file,
            channels,
            scene: info.scene.clone(),
            joint_names: info.joint_names.clone(),
            scratch: Vec::new(),
            ticks: 0,
            progress,
        })
    }

    pub(super) fn tick(&mut self, tick: &Tick) -> Result<(), RecordingError> {
        self.json(self.channels.tick, tick, tick)?;
        self.json(self.channels.measurement, tick, &tick.measurement)?;
        self.protobuf(self.channels.transforms, tick, &views::transforms(&self.scene, tick))?;
        self.protobuf(self.channels.joints, tick, &views::joint_states(&self.joint_names, tick))?;
        if self.ticks.is_multiple_of(BODIES_PERIOD_TICKS) {
            self.protobuf(self.channels.scene, tick, &views::bodies(&self.scene, tick))?;
        }
        if self.ticks.is_multiple_of(CONTACTS_PERIOD_TICKS) {
            self.protobuf(self.channels.scene, tick, &views::contacts(tick))?;
        }
        for line in views::logs(tick) {
            self.protobuf(self.channels.log, tick, &line)?;
        }
        self.ticks += 1;
        Ok(())
    }

    pub(super) fn flush(&mut self) -> Result<(), RecordingError> {
        self.file.flush().map_err(|error| self.failed(error))?;
        self.progress.keep(self.ticks);
        Ok(())
    }

    /// The error of a write, with its first cause.
    fn failed(&self, error: impl std::fmt::Display) -> RecordingError {
        RecordingError::Write {
            path: self.path.clone(),
            ticks: self.progress.safe_ticks(),
            bytes: self.progress.bytes(),
            why: self.progress.cause().unwrap_or_else(|| error.to_string()),
        }
    }

    /// Closes the file and returns how many ticks it holds.
    pub(super) fn end(mut self, end: Option<(&RecordingEnd, u64)>) -> Result<u64, RecordingError> {
        if let Some((end, dropped)) = end {
            let metadata = [
                ("state_hash", format!("{:016x}", end.state_hash)),
                ("verdict", end.verdict.clone()),
                ("ticks", self.ticks.to_string()),
                ("dropped_ticks", dropped.to_string()),
            ]
            .map(|(key, value)| (key.to_owned(), value));
            self.file
                .write_metadata(&Metadata {
                    name: METADATA_END.to_owned(),
                    metadata: metadata.into(),
                })
                .map_err(|error| self.failed(error))?;
        }
        self.file.finish().map_err(|error| self.failed(error))?;
        // The writer leaves the last bytes to the buffer below it, which would lose their error.
        self.file.into_inner().flush().map_err(|error| RecordingError::Write {
            path: self.path,
            ticks: self.progress.safe_ticks(),
            bytes: self.progress.bytes(),
            why: error.to_string(),
        })?;
        self.progress.keep(self.ticks);
        Ok(self.ticks)
    }

    fn json(
        &mut self,
        channel: u16,
        tick: &Tick,
        record: &impl serde::Serialize,
    ) -> Result<(), RecordingError> {
        self.scratch.clear();
        serde_json::to_writer(&mut self.scratch, record).map_err(|error| self.failed(error))?;
        self.write(channel, tick)
    }

    fn protobuf<M: Encode>(
        &mut self,
        channel: u16,
        tick: &Tick,
        message: &M,
    ) -> Result<(), RecordingError> {
        self.scratch.clear();
        message.encode(&mut self.scratch).map_err(|error| self.failed(error))?;
        self.write(channel, tick)
    }

    fn write(&mut self, channel_id: u16, tick: &Tick) -> Result<(), RecordingError> {
        // Casts of floats to integers saturate and turn NaN into 0: a broken clock cannot stop the recording.
        let time_ns = (tick.measurement.t_s * 1e9).round() as u64;
        let header = MessageHeader {
            channel_id,
            sequence: tick.index as u32,
            log_time: time_ns,
            publish_time: time_ns,
        };
        self.file.write_to_known_channel(&header, &self.scratch).map_err(|error| self.failed(error))
    }
}

fn add_channels(file: &mut Writer<BufWriter<WatchedFile>>) -> mcap::McapResult<Channels> {
    Ok(Channels {
        transforms: add_protobuf::<FrameTransforms>(file, "/tf")?,
        scene: add_protobuf::<SceneUpdate>(file, "/scene")?,
        joints: add_protobuf::<JointStates>(file, "/joint_states")?,
        log: add_protobuf::<Log>(file, "/log")?,
        tick: add_json(file, "twin.Tick", TICK_TOPIC)?,
        measurement: add_json(file, "twin.Measurement", MEASUREMENT_TOPIC)?,
    })
}

fn add_protobuf<M: Encode>(
    file: &mut Writer<BufWriter<WatchedFile>>,
    topic: &str,
) -> mcap::McapResult<u16> {
    let schema = match M::get_schema() {
        Some(schema) => file.add_schema(&schema.name, &schema.encoding, &schema.data)?,
        // Zero is MCAP's "no schema".
        None => 0,
    };
    file.add_channel(schema, topic, &M::get_message_encoding(), &BTreeMap::new())
}

fn add_json(
    file: &mut Writer<BufWriter<WatchedFile>>,
    name: &str,
    topic: &str,
) -> mcap::McapResult<u16> {
    let schema = file.add_schema(name, "jsonschema", ANY_OBJECT.as_bytes())?;
    file.add_channel(schema, topic, "json", &BTreeMap::new())
}
