//! An MCAP file that is still being written: reads its records as they become complete.

use std::io::SeekFrom;
use std::path::Path;
use std::time::Duration;

use super::super::table::{Input, read_at};
use super::Shared;
use twin_input::budget::RECORD_BYTES;
use twin_input::{Inflation, file};
use twin_record::pieces::{CHUNK, DATA_END, FOOTER, HEAD_BYTES, Next, OPEN, unpack};

/// Pause before a file that did not grow is checked again.
const LOOK: Duration = Duration::from_millis(50);

/// Lengths that recorders write at the head of a chunk until they close it and know its length.
const UNFINISHED: [u64; 2] = [0, OPEN];

/// Reads `path` from its start and continues as it grows. A file that is replaced or becomes shorter is read from its start
/// again.
pub(super) fn follow(shared: &Shared, path: &Path) {
    while !shared.is_stopped() {
        match file::open(path) {
            Ok(mut file) => {
                shared.is_connected();
                if let Err(why) = read(shared, &mut file) {
                    shared.is_lost(&why);
                }
            }
            Err(error) => shared.is_lost(&error.to_string()),
        }
        shared.pause(LOOK * 10);
    }
}

/// Reads until it is told to stop, the recorder closes the file, or the file becomes shorter.
fn read(shared: &Shared, file: &mut dyn Input) -> Result<(), String> {
    let (mut at, mut inflation) = (0, Inflation::default());
    loop {
        if shared.is_stopped() {
            return Ok(());
        }
        shared.judge_again();
        let length = file.seek(SeekFrom::End(0)).map_err(|error| error.to_string())?;
        if length < at {
            return Err("the file became shorter".to_owned());
        }
        if at == 0 && length >= mcap::MAGIC.len() as u64 {
            let magic = read_at(file, 0, mcap::MAGIC.len() as u64).map_err(|e| e.to_string())?;
            if magic != mcap::MAGIC {
                return Err("it is no MCAP file".to_owned());
            }
            at = mcap::MAGIC.len() as u64;
        }
        if at == 0 || length < at + HEAD_BYTES as u64 {
            shared.pause(LOOK);
            continue;
        }
        let head = read_at(file, at, HEAD_BYTES as u64).map_err(|error| error.to_string())?;
        let body = head[1..].first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
        if matches!(head[0], DATA_END | FOOTER) {
            return ended(shared, file, length);
        }
        let is_open = UNFINISHED.contains(&body);
        if !is_open
            && body > RECORD_BYTES.most
            && let Some(damage) = Next::TooLong(body).damage(at)
        {
            return Err(damage);
        }
        if is_open || length < at + HEAD_BYTES as u64 + body {
            shared.pause(LOOK);
            continue;
        }
        let record =
            read_at(file, at, HEAD_BYTES as u64 + body).map_err(|error| error.to_string())?;
        at += record.len() as u64;
        if record[0] == CHUNK {
            let end = unpack(&record, true, &mut inflation, &mut |record| shared.take(record));
            end.map_err(|error| format!("a chunk is damaged: {error}"))?;
        } else if let Ok(record) = mcap::parse_record(record[0], &record[HEAD_BYTES..]) {
            shared.take(record);
        }
    }
}

/// Waits after the recorder closed the file: no record follows, unless the recorder starts the file again.
fn ended(shared: &Shared, file: &mut dyn Input, length: u64) -> Result<(), String> {
    shared.is_lost("the recorder closed the file");
    while !shared.is_stopped() {
        shared.pause(LOOK * 10);
        let now = file.seek(SeekFrom::End(0)).map_err(|error| error.to_string())?;
        if now < length {
            return Err("the recorder started the file again".to_owned());
        }
    }
    Ok(())
}
