use std::collections::BTreeMap;

use super::*;

/// A chunk record: compression, claimed size and content; without a checksum.
fn chunk(compression: &str, claimed: u64, content: &[u8]) -> Vec<u8> {
    let mut body = vec![0; 16];
    body.extend(claimed.to_le_bytes());
    body.extend([0; 4]);
    body.extend((compression.len() as u32).to_le_bytes());
    body.extend(compression.bytes());
    body.extend((content.len() as u64).to_le_bytes());
    body.extend(content);
    record(CHUNK, &body)
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

fn opcodes(chunk: &[u8]) -> (usize, Option<String>) {
    let mut seen = 0;
    let end = unpack(chunk, true, &mut Inflation::default(), &mut |_| seen += 1);
    (seen, end.err().map(|error| error.to_string()))
}

#[test]
fn a_record_as_long_as_the_limit_is_read_and_one_byte_more_is_damage() {
    let head = |length: u64| [&[0x0C][..], &length.to_le_bytes()].concat();
    let mut buffer = Vec::new();
    let longest = RECORD_BYTES.most;
    let mut input = head(longest).chain_zeros(longest);
    assert_eq!(next(&mut input, &mut buffer).unwrap(), Next::Record);
    let found = next(&mut &head(longest + 1)[..], &mut buffer).unwrap();
    assert_eq!(found, Next::TooLong(longest + 1));
    let said = found.damage(30).unwrap();
    assert!(said.contains("byte 30") && said.contains(&longest.to_string()), "{said}");
}

trait ChainZeros {
    fn chain_zeros(self, count: u64) -> Box<dyn Read>;
}

impl ChainZeros for Vec<u8> {
    fn chain_zeros(self, count: u64) -> Box<dyn Read> {
        Box::new(std::io::Cursor::new(self).chain(std::io::repeat(0).take(count)))
    }
}

#[test]
fn opcode_0_is_damage_wherever_it_stands() {
    let mut buffer = Vec::new();
    let found = next(&mut &record(NO_RECORD, b"abc")[..], &mut buffer).unwrap();
    assert_eq!(found, Next::NoRecord);
    assert!(found.damage(8).is_some_and(|said| said.contains("opcode 0")));
    let inside = [record(0x80, b""), record(NO_RECORD, b""), record(0x80, b"")].concat();
    let (seen, said) = opcodes(&chunk("", inside.len() as u64, &inside));
    assert_eq!(seen, 1);
    assert!(said.is_some_and(|said| said.contains("opcode 0")));
}

#[test]
fn a_chunk_that_claims_more_than_a_record_may_have_is_not_unpacked() {
    for compression in ["zstd", "lz4"] {
        let claimed = RECORD_BYTES.most + 1;
        let (seen, said) = opcodes(&chunk(compression, claimed, &[1; 100]));
        let said = said.expect("it is refused");
        assert_eq!(seen, 0);
        assert!(said.contains(&claimed.to_string()) && said.contains("from 100"), "{said}");
        // One byte less is unpacked, and then fails because these bytes are not compressed ones.
        let (_, said) = opcodes(&chunk(compression, claimed - 1, &[1; 100]));
        assert!(said.is_some_and(|said| !said.contains("claims")));
    }
}

#[test]
fn the_chunks_of_one_input_share_one_budget() {
    let bomb = chunk("zstd", RECORD_BYTES.most, &[1; 100]);
    let mut inflation = Inflation::default();
    let refused = (0..3)
        .filter(|_| {
            let end = unpack(&bomb, true, &mut inflation, &mut |_| {});
            matches!(end, Err(ChunkError::TooInflated(_)))
        })
        .count();
    assert_eq!(refused, 2);
}

#[test]
fn the_chunks_of_the_writer_pass_compressed_or_not() {
    for compression in [None, Some(mcap::Compression::Zstd), Some(mcap::Compression::Lz4)] {
        let mut file = std::io::Cursor::new(Vec::new());
        let options = mcap::WriteOptions::new().compression(compression);
        let mut writer = options.create(&mut file).unwrap();
        let channel = writer.add_channel(0, "/t", "json", &BTreeMap::new()).unwrap();
        for sequence in 0..100 {
            let header = mcap::records::MessageHeader {
                channel_id: channel,
                sequence,
                log_time: 1,
                publish_time: 1,
            };
            writer.write_to_known_channel(&header, b"{}").unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        let bytes = file.into_inner();
        let (mut input, mut buffer) = (&bytes[mcap::MAGIC.len()..], Vec::new());
        let mut messages = 0;
        while next(&mut input, &mut buffer).unwrap() == Next::Record {
            if buffer[0] == CHUNK {
                let mut count = |record: Record<'_>| {
                    messages += usize::from(matches!(record, Record::Message { .. }));
                };
                unpack(&buffer, true, &mut Inflation::default(), &mut count).unwrap();
            }
        }
        assert_eq!(messages, 100, "{compression:?}");
    }
}
