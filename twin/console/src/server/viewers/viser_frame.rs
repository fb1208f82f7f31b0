//! The frame of viser 1.1: lengths, a zstd frame around a `MessagePack` map of messages, then aligned binary buffers.
//!
//! The zstd frame has raw blocks only. That is valid zstd, and compression gains nothing on loopback.

use rmpv::Value;

use crate::server::viewers::pack::{self, map};

/// Alignment of the buffers, counted from the start of the frame, bytes.
const ALIGNMENT: usize = 8;

/// Longest block of a zstd frame, bytes.
const LONGEST_BLOCK: usize = 128 * 1024;

/// Encoded messages that travel in one frame.
#[derive(Debug, Default)]
pub(super) struct Batch {
    messages: Vec<u8>,
    /// Offset of the end of each message, bytes.
    ends: Vec<usize>,
    buffers: Vec<Vec<u8>>,
}

impl Batch {
    /// Adds a message: a map with a `type`.
    pub(super) fn push(&mut self, message: &Value) {
        pack::append(&mut self.messages, message);
        self.ends.push(self.messages.len());
    }

    /// Adds an encoded message; `change` edits its bytes in place.
    pub(super) fn push_encoded(&mut self, message: &[u8], change: impl FnOnce(&mut [u8])) {
        let start = self.messages.len();
        self.messages.extend_from_slice(message);
        change(&mut self.messages[start..]);
        self.ends.push(self.messages.len());
    }

    /// Adds a buffer of numbers; returns the value that refers to it in a message. `dtype` is a type name of numpy.
    pub(super) fn array(&mut self, dtype: &str, bytes: Vec<u8>) -> Value {
        let index = self.buffers.len();
        self.buffers.push(bytes);
        map! { "__binary_index" => index as u64, "dtype" => dtype }
    }

    /// Whether the batch has no messages.
    pub(super) fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Number of messages.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The inner bytes of a recording, before compression: the length of a map, the map, then the aligned buffers;
    /// `times_s` has the time of each message.
    pub(super) fn encode_recording(
        self,
        times_s: &[f64],
        duration_s: f64,
        version: &str,
    ) -> Vec<u8> {
        let mut head = map_of(4);
        pack::append(&mut head, &"durationSeconds".into());
        pack::append(&mut head, &duration_s.into());
        pack::append(&mut head, &"messages".into());
        pack::begin_array(&mut head, self.ends.len());
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        for ((start, end), t_s) in starts.zip(&self.ends).zip(times_s) {
            pack::begin_array(&mut head, 2);
            pack::append(&mut head, &Value::F64(*t_s));
            head.extend(&self.messages[start..*end]);
        }
        pack::append(&mut head, &"viserVersion".into());
        pack::append(&mut head, &version.into());
        self.append_lengths(&mut head);
        let mut inner = (head.len() as u64).to_le_bytes().to_vec();
        inner.extend(head);
        append_aligned(&mut inner, self.buffers);
        inner
    }

    /// The bytes of the frame. `now_s` is the time on a clock that all frames of a connection share, s.
    pub(super) fn encode(self, now_s: f64) -> Vec<u8> {
        let mut inner = map_of(3);
        inner.reserve(self.messages.len() + 64);
        pack::append(&mut inner, &"messages".into());
        pack::begin_array(&mut inner, self.ends.len());
        inner.extend(&self.messages);
        pack::append(&mut inner, &"timestampSec".into());
        pack::append(&mut inner, &now_s.into());
        self.append_lengths(&mut inner);
        let mut frame = Vec::with_capacity(inner.len() + 64);
        frame.extend((inner.len() as u64).to_le_bytes());
        frame.extend((raw_zstd_length(inner.len()) as u64).to_le_bytes());
        append_raw_zstd(&mut frame, &inner);
        append_aligned(&mut frame, self.buffers);
        frame
    }

    fn append_lengths(&self, map: &mut Vec<u8>) {
        let lengths = self.buffers.iter().map(|buffer| Value::from(buffer.len() as u64));
        pack::append(map, &"binaryBufferLengths".into());
        pack::append(map, &Value::Array(lengths.collect()));
    }
}

/// The head of a map of at most 15 entries; the caller appends the entries.
fn map_of(entries: u8) -> Vec<u8> {
    vec![0x80 | entries]
}

fn append_aligned(bytes: &mut Vec<u8>, buffers: Vec<Vec<u8>>) {
    for buffer in buffers {
        bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
        bytes.extend(buffer);
    }
}

/// Bytes of the head of a zstd frame, and of the head of each block.
const ZSTD_HEAD: usize = 9;
const ZSTD_BLOCK_HEAD: usize = 3;

/// Length of the zstd frame around `length` bytes, bytes.
fn raw_zstd_length(length: usize) -> usize {
    ZSTD_HEAD + length.div_ceil(LONGEST_BLOCK).max(1) * ZSTD_BLOCK_HEAD + length
}

/// A zstd frame of raw blocks (RFC 8878): magic, single segment with a 4-byte size, blocks with a 3-byte header.
fn append_raw_zstd(frame: &mut Vec<u8>, bytes: &[u8]) {
    frame.extend([0x28, 0xB5, 0x2F, 0xFD, 0xA0]);
    frame.extend((bytes.len() as u32).to_le_bytes());
    let last = bytes.len().div_ceil(LONGEST_BLOCK).max(1) - 1;
    let mut blocks = bytes.chunks(LONGEST_BLOCK);
    for index in 0..=last {
        let block = blocks.next().unwrap_or_default();
        let header = (block.len() as u32) << 3 | u32::from(index == last);
        frame.extend(&header.to_le_bytes()[..ZSTD_BLOCK_HEAD]);
        frame.extend(block);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::viewers::pack::map;
    use crate::server::viewers::viser_move::Mover;

    #[test]
    fn zstd_itself_reads_the_raw_frame() {
        for length in [0, 1, LONGEST_BLOCK - 1, LONGEST_BLOCK, LONGEST_BLOCK + 1, 400_000] {
            let bytes: Vec<u8> = (0..length).map(|k| (k * 31 % 251) as u8).collect();
            let mut read = zstd::bulk::Decompressor::new().expect("zstd");
            let mut frame = Vec::new();
            append_raw_zstd(&mut frame, &bytes);
            assert_eq!(frame.len(), raw_zstd_length(length));
            assert_eq!(read.decompress(&frame, length + 1).expect("a frame"), bytes);
        }
    }

    #[test]
    fn a_moved_node_is_told_as_the_library_writes_it() {
        let (mut batch, pose) = (Batch::default(), [1.5, -2.0, 0.25, 0.5, -0.5, 0.5, 0.5]);
        Mover::new("/a").place(pose, &mut batch);
        let list = |values: &[f32]| Value::Array(values.iter().copied().map(Value::F32).collect());
        let wanted = [
            map! { "type" => "SetPositionMessage", "name" => "/a", "owner" => "", "position" => list(&pose[..3]) },
            map! { "type" => "SetOrientationMessage", "name" => "/a", "owner" => "", "wxyz" => list(&pose[3..]) },
        ];
        assert_eq!(batch.messages, wanted.map(|message| pack::encode(&message)).concat());
        assert_eq!(batch.len(), 2);
    }

    #[test]
    fn messages_and_aligned_buffers_come_out_as_they_went_in() {
        let mut batch = Batch::default();
        assert!(batch.is_empty());
        let odd = batch.array("|u1", vec![1, 2, 3]);
        let numbers = batch.array("<f8", pack::f64_bytes([0.5, -0.25]));
        batch.push(&map! { "type" => "Probe", "odd" => odd, "numbers" => numbers });
        let frame = batch.encode(12.5);
        let length = |at: usize| u64::from_le_bytes(frame[at..at + 8].try_into().unwrap()) as usize;
        let (n, c) = (length(0), length(8));
        let inner = zstd::bulk::decompress(&frame[16..16 + c], n).expect("a frame");
        assert_eq!(inner.len(), n);
        let inner = pack::decode(&inner).expect("MessagePack");
        assert_eq!(pack::get(&inner, "timestampSec"), Some(&Value::F64(12.5)));
        let messages = pack::get(&inner, "messages").and_then(Value::as_array).expect("a list");
        assert_eq!((messages.len(), pack::text(&messages[0], "type")), (1, Some("Probe")));
        let lengths = Value::Array(vec![3.into(), 16.into()]);
        assert_eq!(pack::get(&inner, "binaryBufferLengths"), Some(&lengths));
        let first = (16 + c).next_multiple_of(8);
        let second = (first + 3).next_multiple_of(8);
        assert_eq!(frame[first..first + 3], [1, 2, 3]);
        assert_eq!(frame[second..], pack::f64_bytes([0.5, -0.25]));
    }
}
