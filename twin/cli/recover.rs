//! `twin recover`: salvages a damaged or unfinished recording.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use twin_record::recover::{Salvaged, recover};

use super::{End, Overwrite, print};

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
    /// The new file; `-` is stdout.
    #[arg(long, short, value_name = "FILE.mcap")]
    output: PathBuf,
    /// Keep the messages of chunks whose checksum is wrong, too; some of them may have wrong values.
    #[arg(long)]
    unverified: bool,
    /// Print exactly one JSON object on stdout.
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    overwrite: Overwrite,
}

pub(super) fn run(args: &RecoverArgs) -> anyhow::Result<End> {
    let outputs = args.overwrite.outputs_beside([&args.file], args.json)?;
    let mut out = outputs.reserve(&args.output, "--output")?.open()?;
    let salvaged = recover(&args.file, &mut out, args.unverified)?;
    out.finish()?;
    print(&outputs, |out| {
        if args.json {
            let mut found = serde_json::to_value(&salvaged)?;
            found["file"] = args.file.display().to_string().into();
            found["output"] = args.output.display().to_string().into();
            found["duration_s"] = salvaged.duration_s().into();
            writeln!(out, "{found}")?;
        } else {
            print_report(out, args, &salvaged)?;
        }
        Ok(())
    })?;
    Ok(End::Passed)
}

fn print_report(out: &mut dyn Write, args: &RecoverArgs, found: &Salvaged) -> io::Result<()> {
    writeln!(
        out,
        "{}: {} messages on {} channels, {:.2} s; {} attachments, {} metadata records",
        args.output.display(),
        found.messages,
        found.channels,
        found.duration_s(),
        found.attachments,
        found.metadata
    )?;
    if found.unverified_messages > 0 {
        writeln!(
            out,
            "  {} of the messages have no checksum that holds: they stood in an unfinished or damaged chunk",
            found.unverified_messages
        )?;
    }
    for loss in &found.losses {
        writeln!(out, "  byte {}, {} bytes: {}", loss.at_byte, loss.bytes, loss.what)?;
    }
    let more = found.damaged_places.saturating_sub(found.losses.len() as u64);
    if more > 0 {
        writeln!(out, "  {more} more places of damage")?;
    }
    writeln!(out, "  {}", lost(found))
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
