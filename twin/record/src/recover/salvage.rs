//! The new file: definitions, messages, attachments and metadata as they are salvaged.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use super::report::Salvaged;
use mcap::records::{Channel, MessageHeader, Metadata, Record, SchemaHeader};
use mcap::{Attachment, McapError, WriteOptions, Writer};

/// Name of the metadata record that says what a file was salvaged from.
pub const METADATA_RECOVERED: &str = "twin.recovered";

/// A definition, and whether it stands where its messages stand: in a chunk whose checksum holds, or outside of chunks.
struct Defined<T> {
    is: T,
    sure: bool,
}

/// Definitions by the numbers that the damaged file uses.
#[derive(Default)]
pub(super) struct Definitions {
    schemas: BTreeMap<u16, Defined<(SchemaHeader, Vec<u8>)>>,
    channels: BTreeMap<u16, Defined<Channel>>,
}

impl Definitions {
    /// Keeps a schema or a channel; returns whether the record is one. The first definition stays, but one that is `sure` takes the
    /// place of one that is not: the summary and damaged chunks only fill gaps.
    pub(super) fn add(&mut self, record: &Record<'_>, sure: bool) -> bool {
        match record {
            Record::Schema { header, data } => {
                keep(&mut self.schemas, header.id, sure, || (header.clone(), data.to_vec()));
            }
            Record::Channel(channel) => {
                keep(&mut self.channels, channel.id, sure, || channel.clone());
            }
            _ => return false,
        }
        true
    }

    /// Whether messages of this channel can be used.
    pub(super) fn has(&self, channel: u16) -> bool {
        self.channels.contains_key(&channel)
    }
}

fn keep<T>(all: &mut BTreeMap<u16, Defined<T>>, id: u16, sure: bool, is: impl FnOnce() -> T) {
    if all.get(&id).is_none_or(|known| sure && !known.sure) {
        all.insert(id, Defined { is: is(), sure });
    }
}

/// The file that is written.
pub(super) struct Salvage<W: Write + Seek> {
    file: Writer<W>,
    /// Numbers of the channels in the new file by those of the damaged one, and whether their definitions were sure.
    channels: BTreeMap<u16, (u16, bool)>,
    /// What is known of the damaged file.
    pub known: Definitions,
    /// The account of it.
    pub report: Salvaged,
}

impl<W: Write + Seek> Salvage<W> {
    /// Begins the new file; `profile` and `library` are those of the damaged one.
    pub(super) fn new(out: W, profile: &str, library: &str) -> Result<Self, McapError> {
        let options = WriteOptions::new().profile(profile).compression_threads(0);
        // The file may be a pipe.
        let mut options = options.disable_seeking(true);
        if !library.is_empty() {
            options = options.library(library);
        }
        Ok(Self {
            file: options.create(out)?,
            channels: BTreeMap::new(),
            known: Definitions::default(),
            report: Salvaged::default(),
        })
    }

    /// Takes a record of the data section, whether its checksum was `verified` or not.
    pub(super) fn take(&mut self, record: Record<'_>, verified: bool) -> Result<(), McapError> {
        if self.known.add(&record, verified) {
            return Ok(());
        }
        match record {
            Record::Message { header, data } => self.message(header, &data, verified),
            Record::Attachment { header, data, .. } => {
                self.report.attachments += 1;
                self.file.attach(&Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data,
                })
            }
            Record::Metadata(metadata) => {
                self.report.metadata += 1;
                self.file.write_metadata(&metadata)
            }
            _ => Ok(()),
        }
    }

    fn message(
        &mut self,
        header: MessageHeader,
        data: &[u8],
        verified: bool,
    ) -> Result<(), McapError> {
        let Some(channel_id) = self.channel(header.channel_id)? else {
            self.report.lost_messages += 1;
            return Ok(());
        };
        self.report.keep(header.log_time, verified);
        self.file.write_to_known_channel(&MessageHeader { channel_id, ..header }, data)
    }

    /// The number of a channel in the new file; `None` if the damaged file defines no such channel.
    fn channel(&mut self, id: u16) -> Result<Option<u16>, McapError> {
        let Some(Defined { is: channel, sure }) = self.known.channels.get(&id) else {
            return Ok(None);
        };
        if let Some((found, _)) = self.channels.get(&id).filter(|(_, was_sure)| was_sure == sure) {
            return Ok(Some(*found));
        }
        let Channel { schema_id, topic, message_encoding, metadata, .. } = channel;
        // Without its schema a channel still has its messages.
        let schema = match self.known.schemas.get(schema_id) {
            Some(Defined { is: (schema, data), .. }) => {
                self.file.add_schema(&schema.name, &schema.encoding, data)?
            }
            None => 0,
        };
        let own = self.file.add_channel(schema, topic, message_encoding, metadata)?;
        self.channels.insert(id, (own, *sure));
        Ok(Some(own))
    }

    /// Writes where the file comes from, and its summary.
    pub(super) fn finish(mut self, from: &str) -> Result<Salvaged, McapError> {
        // Channels without a message count, too.
        for id in self.known.channels.keys().copied().collect::<Vec<_>>() {
            self.channel(id)?;
        }
        let report = &mut self.report;
        report.channels = self.channels.len() as u64;
        let facts = [
            ("file", from.to_owned()),
            ("messages", report.messages.to_string()),
            ("unverified_messages", report.unverified_messages.to_string()),
            ("lost_messages_at_least", report.lost_messages.to_string()),
            ("damaged_places", report.damaged_places.to_string()),
            ("finished", report.finished.to_string()),
        ]
        .map(|(key, value)| (key.to_owned(), value));
        self.file.write_metadata(&Metadata {
            name: METADATA_RECOVERED.to_owned(),
            metadata: facts.into(),
        })?;
        self.file.finish()?;
        Ok(self.report)
    }
}
