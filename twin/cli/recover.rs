//! `twin recover`: salvages a damaged or unfinished recording.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use twin_record::recover::{Salvaged, recover};

use super::End;

const HELP: &str = "\
What is kept: every chunk whose checksum holds; of the last, unfinished chunk every whole message; schemas, channels, metadata, and
attachments that are whole. Behind damage the reading goes on at the next readable record. Recordings of other programs work, too.
The damaged file stays as it is.

Exit code 0: a file was written, also if something is lost; 2: nothing could be read.";

#[derive(Args)]
#[command(after_help = HELP)]
pub(super) struct RecoverArgs {
    /// MCAP file that is cut off, unfinished or damaged.
    file: PathBuf,
    /// The new file; it must not exist.
    #[arg(long, short, value_name = "FILE.mcap")]
    output: PathBuf,
    /// Keep the messages of chunks whose checksum is wrong, too; some of them may have wrong values.
    #[arg(long)]
    unverified: bool,
    /// Print exactly one JSON object on stdout.
    #[arg(long)]
    pub(super) json: bool,
}

pub(super) fn run(args: &RecoverArgs) -> anyhow::Result<End> {
    let out = create(&args.output)?;
    let salvaged = match recover(&args.file, BufWriter::new(out), args.unverified) {
        Ok(salvaged) => salvaged,
        Err(error) => {
            // Half of a salvage is no recording; that it cannot be removed does not matter beside the error.
            let _ = std::fs::remove_file(&args.output);
            return Err(error.into());
        }
    };
    if args.json {
        let mut found = serde_json::to_value(&salvaged)?;
        found["file"] = args.file.display().to_string().into();
        found["output"] = args.output.display().to_string().into();
        found["duration_s"] = salvaged.duration_s().into();
        println!("{found}");
    } else {
        print(args, &salvaged);
    }
    Ok(End::Passed)
}

/// Opens the new file. This is the only place of this command that creates one.
fn create(path: &Path) -> anyhow::Result<File> {
    File::options().write(true).create_new(true).open(path).with_context(|| {
        format!("{}: cannot be created; name a file that does not exist with -o", path.display())
    })
}

fn print(args: &RecoverArgs, found: &Salvaged) {
    println!(
        "{}: {} messages on {} channels, {:.2} s; {} attachments, {} metadata records",
        args.output.display(),
        found.messages,
        found.channels,
        found.duration_s(),
        found.attachments,
        found.metadata
    );
    if found.unverified_messages > 0 {
        println!(
            "  {} of the messages have no checksum that holds: they stood in an unfinished or damaged chunk",
            found.unverified_messages
        );
    }
    for loss in &found.losses {
        println!("  byte {}, {} bytes: {}", loss.at_byte, loss.bytes, loss.what);
    }
    let more = found.damaged_places.saturating_sub(found.losses.len() as u64);
    if more > 0 {
        println!("  {more} more places of damage");
    }
    println!("  {}", lost(found));
}

/// What is lost, in a sentence.
fn lost(found: &Salvaged) -> String {
    let finished =
        if found.finished { "the recording was finished" } else { "the recording had no end" };
    match (found.lost_messages, found.lost_more) {
        (0, false) => format!("{finished}; no message is lost"),
        (0, true) => format!("{finished}; how many messages are lost is unknown"),
        (lost, more) => {
            let least = if more { "at least " } else { "" };
            let span = if found.lost_s > 0.0 {
                format!(", {:.2} s of damaged chunks", found.lost_s)
            } else {
                String::new()
            };
            format!("{finished}; {least}{lost} messages are lost{span}")
        }
    }
}
