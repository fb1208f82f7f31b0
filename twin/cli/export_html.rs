//! `twin export html`: a recording as one page.

use std::path::PathBuf;

use clap::Args;
use twin_console::replay;

use super::End;

#[derive(Args)]
pub(super) struct HtmlArgs {
    /// A recording of `twin fly --record` or of a failed test.
    recording: PathBuf,
    /// The page [default: beside the recording, with the extension html].
    #[arg(long, short, value_name = "FILE.html")]
    output: Option<PathBuf>,
}

pub(super) fn run(args: &HtmlArgs) -> anyhow::Result<End> {
    let HtmlArgs { recording, output } = args;
    let page = output.clone().unwrap_or_else(|| recording.with_extension("html"));
    let opens_at_s = replay::export(recording, &page, None)?;
    println!("{}", page.display());
    eprintln!("opens at {opens_at_s:.2} s");
    Ok(End::Passed)
}
