//! The frame of viser 1.1: lengths, a zstd frame around a `MessagePack` map of messages, then aligned binary buffers.
//!
//! The zstd frame holds raw blocks only: valid, and nothing on loopback is gained by compressing.

use rmpv::Value;

use crate::server::viewers::pack::{self, map};

/// Buffers start at multiples of this, counted from the start of the frame, bytes.
const ALIGNMENT: usize = 8;

/// Longest block of a zstd frame, bytes.
const LONGEST_BLOCK: usize = 128 * 1024;

/// Messages that travel in one frame.
#[derive(Debug, Default)]
pub(super) struct Batch {
    messages: Vec<Value>,
    buffers: Vec<Vec<u8>>,
}

impl Batch {
    /// Adds a message: a map with a `type`.
    pub(super) fn push(&mut self, message: Value) {
        self.messages.push(message);
    }

    /// Adds a buffer of numbers and returns what stands for it in a message; `dtype` as in numpy.
    pub(super) fn array(&mut self, dtype: &str, bytes: Vec<u8>) -> Value {
        let index = self.buffers.len();
        self.buffers.push(bytes);
        map! { "__binary_index" => index as u64, "dtype" => dtype }
    }

    /// Nothing to send.
    pub(super) fn is_empty(&self) -> bool {
        self.messages.is_empty()
    }

    /// Messages in it.
    pub(super) fn len(&self) -> usize {
        self.messages.len()
    }

    /// The inner bytes of a recording, before compression: the length of a map, the map, then the aligned buffers;
    /// `times_s` has the time of each message.
    pub(super) fn encode_recording(
        self,
        times_s: &[f64],
        duration_s: f64,
        version: &str,
    ) -> Vec<u8> {
        let lengths = self.buffers.iter().map(|buffer| Value::from(buffer.len() as u64));
        let lengths = Value::Array(lengths.collect());
        let messages = times_s.iter().zip(self.messages);
        let messages = messages.map(|(t_s, message)| Value::Array(vec![Value::F64(*t_s), message]));
        let head = pack::encode(&map! {
            "durationSeconds" => duration_s,
            "messages" => Value::Array(messages.collect()),
            "viserVersion" => version,
            "binaryBufferLengths" => lengths,
        });
        let mut inner = (head.len() as u64).to_le_bytes().to_vec();
        inner.extend(head);
        append_aligned(&mut inner, self.buffers);
        inner
    }

    /// The bytes of the frame; `now_s` on one clock for all frames of a connection.
    pub(super) fn encode(self, now_s: f64) -> Vec<u8> {
        let lengths = self.buffers.iter().map(|buffer| Value::from(buffer.len() as u64));
        let inner = pack::encode(&map! {
            "messages" => Value::Array(self.messages),
            "timestampSec" => now_s,
            "binaryBufferLengths" => Value::Array(lengths.collect()),
        });
        let packed = raw_zstd(&inner);
        let mut frame = Vec::with_capacity(packed.len() + 16);
        frame.extend((inner.len() as u64).to_le_bytes());
        frame.extend((packed.len() as u64).to_le_bytes());
        frame.extend(packed);
        append_aligned(&mut frame, self.buffers);
        frame
    }
}

fn append_aligned(bytes: &mut Vec<u8>, buffers: Vec<Vec<u8>>) {
    for buffer in buffers {
        bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
        bytes.extend(buffer);
    }
}

/// A zstd frame of raw blocks (RFC 8878): magic, single segment with a 4-byte size, blocks with a 3-byte header.
fn raw_zstd(bytes: &[u8]) -> Vec<u8> {
    let mut frame = vec![0x28, 0xB5, 0x2F, 0xFD, 0xA0];
    frame.extend((bytes.len() as u32).to_le_bytes());
    let last = bytes.len().div_ceil(LONGEST_BLOCK).max(1) - 1;
    let mut blocks = bytes.chunks(LONGEST_BLOCK);
    for index in 0..=last {
        let block = blocks.next().unwrap_or_default();
        let header = (block.len() as u32) << 3 | u32::from(index == last);
        frame.extend(&header.to_le_bytes()[..3]);
        frame.extend(block);
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zstd_itself_reads_the_raw_frame() {
        for length in [0, 1, LONGEST_BLOCK - 1, LONGEST_BLOCK, LONGEST_BLOCK + 1, 400_000] {
            let bytes: Vec<u8> = (0..length).map(|k| (k * 31 % 251) as u8).collect();
            let mut read = zstd::bulk::Decompressor::new().expect("zstd");
            assert_eq!(read.decompress(&raw_zstd(&bytes), length + 1).expect("a frame"), bytes);
        }
    }

    #[test]
    fn messages_and_aligned_buffers_come_out_as_they_went_in() {
        let mut batch = Batch::default();
        assert!(batch.is_empty());
        let odd = batch.array("|u1", vec![1, 2, 3]);
        let numbers = batch.array("<f8", pack::f64_bytes([0.5, -0.25]));
        batch.push(map! { "type" => "Probe", "odd" => odd, "numbers" => numbers });
        let frame = batch.encode(12.5);
        let length = |at: usize| u64::from_le_bytes(frame[at..at + 8].try_into().unwrap()) as usize;
        let (n, c) = (length(0), length(8));
        let inner = zstd::bulk::decompress(&frame[16..16 + c], n).expect("a frame");
        assert_eq!(inner.len(), n);
        let inner = pack::decode(&inner).expect("MessagePack");
        assert_eq!(pack::get(&inner, "timestampSec"), Some(&Value::F64(12.5)));
        let lengths = Value::Array(vec![3.into(), 16.into()]);
        assert_eq!(pack::get(&inner, "binaryBufferLengths"), Some(&lengths));
        let first = (16 + c).next_multiple_of(8);
        let second = (first + 3).next_multiple_of(8);
        assert_eq!(frame[first..first + 3], [1, 2, 3]);
        assert_eq!(frame[second..], pack::f64_bytes([0.5, -0.25]));
    }
}
