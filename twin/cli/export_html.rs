//! `twin export html`: a recording as one page.

use std::path::PathBuf;

use clap::Args;
use twin_console::replay;
use twin_record::output::{Output, note};

use super::{End, Overwrite, print};

#[derive(Args)]
pub(super) struct HtmlArgs {
    /// A recording of `twin fly --record` or of a failed test.
    recording: PathBuf,
    /// The page, in an existing folder; `-` is stdout [default: beside the recording, with the extension html].
    #[arg(long, short, value_name = "FILE.html")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

pub(super) fn run(args: &HtmlArgs) -> anyhow::Result<End> {
    let outputs = args.overwrite.outputs();
    outputs.protect([&args.recording]);
    let page = args.output.clone().unwrap_or_else(|| args.recording.with_extension("html"));
    let output = outputs.reserve(&page, "--output")?;
    let (text, opens_at_s) = replay::export(&args.recording, None)?;
    hand_over(output, text.as_bytes())?;
    note(format_args!("opens at {opens_at_s:.2} s"));
    Ok(End::Passed)
}

/// Writes an export, and prints its path unless stdout has the export itself.
pub(super) fn hand_over(output: Output, bytes: &[u8]) -> anyhow::Result<()> {
    let (path, outputs) = (output.path().display().to_string(), output.outputs().clone());
    let printed = output.is_stdout();
    output.write(bytes)?;
    if printed {
        return Ok(());
    }
    print(&outputs, |out| Ok(writeln!(out, "{path}")?))
}
