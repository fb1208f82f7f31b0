//! Reads PX4's own log (`.ulg`) and gives its content as the records of an MCAP file: schemas, channels, messages.
//!
//! In: the bytes after the magic. Out: as from [`super::container::read`]. A topic gets the name that PX4's bridge to ROS 2 gives
//! it (`/fmu/out/vehicle_attitude`). Its schema is `px4_msgs/msg/VehicleAttitude` with the definition from the log. The log time
//! of a message is its own time. The published readers expect a well-formed file; this module replaces them for that reason.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;

use mcap::records::{Channel, MessageHeader, Record, SchemaHeader};

use super::findings::{ContainerError, Findings};
use twin_input::work;
use twin_record::pieces::fill;

/// First bytes of every log; a version byte follows.
pub(super) const MAGIC: [u8; 7] = *b"ULog\x01\x12\x35";

/// Bytes of version and start time after the magic.
const HEADER_REST_BYTES: u64 = 9;

/// Bytes of size and kind before every message.
const HEAD_BYTES: usize = 3;

/// Name of the encoding of schema and message in the records.
pub(super) const ENCODING: &str = "ulog";

/// Topics that go to the flight controller, and topics whose messages have the format of another topic.
const TO_THE_CONTROLLER: [&str; 3] =
    ["vehicle_visual_odometry", "vehicle_mocap_odometry", "trajectory_setpoint"];
const OF_ODOMETRY: [&str; 2] = ["vehicle_visual_odometry", "vehicle_mocap_odometry"];

/// Reads a log to its end, or to the first byte where it is broken.
pub(super) fn read(
    input: &mut impl Read,
    on: &mut dyn FnMut(Record<'_>),
) -> Result<Findings, ContainerError> {
    let mut log = Log {
        findings: Findings { profile: ENCODING.to_owned(), ..Findings::default() },
        ..Log::default()
    };
    let mut message = Vec::new();
    let mut offset = MAGIC.len() as u64 + HEADER_REST_BYTES;
    if !fill(input, HEADER_REST_BYTES, &mut message)? {
        log.findings.problem("the file ends inside its header".to_owned());
        return Ok(log.findings);
    }
    loop {
        message.clear();
        let headed = fill(input, HEAD_BYTES as u64, &mut message)?;
        if !headed {
            log.findings.complete = message.is_empty();
            if !log.findings.complete {
                log.cut_off(offset);
            }
            return Ok(log.findings);
        }
        let size = u16::from_le_bytes([message[0], message[1]]);
        if !fill(input, u64::from(size), &mut message)? {
            log.cut_off(offset);
            return Ok(log.findings);
        }
        if let Err(why) = log.take(message[2], &message[HEAD_BYTES..], on) {
            log.findings
                .problem(format!("message at byte {offset}: {why}; nothing after it is read"));
            return Ok(log.findings);
        }
        offset += message.len() as u64;
    }
}

#[derive(Default)]
struct Log {
    findings: Findings,
    /// Definitions by name, as the file has them.
    formats: BTreeMap<String, String>,
    /// Numbers of the schemas that were passed on already, by name of the definition.
    schemas: BTreeMap<String, u16>,
    /// Number of messages of each channel so far.
    sequence: BTreeMap<u16, u32>,
}

impl Log {
    fn cut_off(&mut self, offset: u64) {
        self.findings.problem(format!(
            "the file ends inside the message at byte {offset}: the recorder was stopped or the copy is not whole"
        ));
    }

    /// Handles one message; an error ends the reading.
    fn take(
        &mut self,
        kind: u8,
        body: &[u8],
        on: &mut dyn FnMut(Record<'_>),
    ) -> Result<(), String> {
        match kind {
            b'B' => flags(body),
            b'F' => {
                let text = String::from_utf8_lossy(body).into_owned();
                let (name, _) = text.split_once(':').ok_or("a format without a name")?;
                self.formats.insert(name.to_owned(), text);
                Ok(())
            }
            b'I' => {
                self.info(body);
                Ok(())
            }
            b'A' => self.subscribe(body, on),
            b'D' => self.data(body, on),
            b'O' => {
                self.findings.dropouts += 1;
                Ok(())
            }
            b'M' | b'P' | b'Q' | b'R' | b'L' | b'C' | b'S' => Ok(()),
            _ => Err(format!("kind {:?} is unknown: the file is damaged", char::from(kind))),
        }
    }

    /// Reads an information message such as `char[3] sys_name`.
    fn info(&mut self, body: &[u8]) {
        let Some((key, value)) =
            body.split_first().and_then(|(n, rest)| rest.split_at_checked(usize::from(*n)))
        else {
            return;
        };
        if key.ends_with(b" sys_name") || key.ends_with(b" ver_sw") {
            let word = String::from_utf8_lossy(value);
            let library = &mut self.findings.library;
            let said = format!("{library} {}", word.trim_end_matches('\0'));
            said.trim().clone_into(library);
        }
    }

    fn subscribe(&mut self, body: &[u8], on: &mut dyn FnMut(Record<'_>)) -> Result<(), String> {
        let [instance, low, high, name @ ..] = body else {
            return Err("a subscription too short".into());
        };
        let id = u16::from_le_bytes([*low, *high]);
        let name = String::from_utf8_lossy(name).into_owned();
        let schema_id = if let Some(number) = self.schemas.get(&name) {
            *number
        } else {
            let Some(definition) = self.definition(&name) else {
                self.findings.problem(format!("topic {name} has no definition and is not read"));
                return Ok(());
            };
            let number = u16::try_from(self.schemas.len() + 1)
                .map_err(|_| format!("more than {} topics", u16::MAX))?;
            let (name_sent, encoding) = (schema_name(&name), ENCODING.to_owned());
            let header = SchemaHeader { id: number, name: name_sent, encoding };
            on(Record::Schema { header, data: definition.as_bytes().into() });
            self.schemas.insert(name.clone(), number);
            number
        };
        on(Record::Channel(Channel {
            id,
            schema_id,
            topic: topic(&name, *instance),
            message_encoding: ENCODING.to_owned(),
            metadata: [("instance".to_owned(), instance.to_string())].into(),
        }));
        Ok(())
    }

    /// The definition of `name` and of every type that it contains, one a line, its own first.
    fn definition(&self, name: &str) -> Option<String> {
        let (name, _) = self.formats.get_key_value(name)?;
        let mut needed = vec![name.as_str()];
        let mut known = BTreeSet::from([name.as_str()]);
        let mut next = 0;
        while let Some(text) = needed.get(next).and_then(|name| self.formats.get(*name)) {
            // In the order of their names, as the formats are.
            let others: BTreeSet<&str> = types(text).collect();
            for other in others {
                work::steps(1);
                if let Some((other, _)) = self.formats.get_key_value(other)
                    && known.insert(other)
                {
                    needed.push(other);
                }
            }
            next += 1;
        }
        let texts: Vec<&str> = needed.iter().map(|name| self.formats[*name].as_str()).collect();
        Some(texts.join("\n"))
    }

    fn data(&mut self, body: &[u8], on: &mut dyn FnMut(Record<'_>)) -> Result<(), String> {
        let Some((id, data)) = body.split_first_chunk::<2>() else {
            return Err("a data message too short".to_owned());
        };
        let Some(time_us) = data.first_chunk::<8>() else {
            return Err("a data message without a time".to_owned());
        };
        let channel_id = u16::from_le_bytes(*id);
        let log_time = u64::from_le_bytes(*time_us).saturating_mul(1000);
        let sequence = self.sequence.entry(channel_id).or_default();
        *sequence = sequence.wrapping_add(1);
        let header =
            MessageHeader { channel_id, sequence: *sequence, log_time, publish_time: log_time };
        on(Record::Message { header, data: data.into() });
        Ok(())
    }
}

/// The types of the fields in the definition `text`.
fn types(text: &str) -> impl Iterator<Item = &str> {
    let fields = text.split_once(':').map_or("", |(_, fields)| fields).split(';');
    fields.filter_map(|field| field.trim().split([' ', '[']).next())
}

/// Checks the compatibility flags. Unknown incompatible flags mean that the rest cannot be understood.
fn flags(body: &[u8]) -> Result<(), String> {
    let incompatible = body.get(8..16).ok_or("flags too short")?;
    // Bit 0 says that data was appended; it is read like the rest.
    let unknown = incompatible[0] & !1 != 0 || incompatible[1..].iter().any(|byte| *byte != 0);
    if unknown {
        Err("the log needs a newer reader (unknown incompatible flags)".to_owned())
    } else {
        Ok(())
    }
}

/// The topic `/fmu/out/battery_status`; further instances append their number.
fn topic(name: &str, instance: u8) -> String {
    let way = if TO_THE_CONTROLLER.contains(&name) { "in" } else { "out" };
    match instance {
        0 => format!("/fmu/{way}/{name}"),
        _ => format!("/fmu/{way}/{name}/{instance}"),
    }
}

/// The schema name `px4_msgs/msg/BatteryStatus`.
fn schema_name(name: &str) -> String {
    let name = if OF_ODOMETRY.contains(&name) { "vehicle_odometry" } else { name };
    let camel = name.split('_').map(|word| {
        let mut letters = word.chars();
        letters
            .next()
            .map(|first| first.to_ascii_uppercase().to_string() + letters.as_str())
            .unwrap_or_default()
    });
    format!("px4_msgs/msg/{}", camel.collect::<String>())
}

#[cfg(test)]
#[path = "ulog_tests.rs"]
mod tests;
