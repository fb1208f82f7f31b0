//! `twin compare`: recorded flights beside each other.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use twin_lab::compare::{Alignment, Comparison, Flown, MOST_FLIGHTS, Pair, compare, page};
use twin_record::read_recording;

use super::forked::print_rows;
use super::{End, Overwrite, place, print};

#[derive(Args)]
pub(super) struct CompareArgs {
    /// Two to six recordings; the first is the one that the others are compared with.
    #[arg(num_args = 2..=MOST_FLIGHTS, required = true)]
    recordings: Vec<PathBuf>,
    /// Which times belong together: `start`, `best` (the offset at which the positions are closest), or `event:TEXT` (the first event whose
    /// kind or sentence has this text, such as `event:grasp`).
    #[arg(long, default_value = "start", value_parser = parse_alignment)]
    align: Alignment,
    /// Write the comparison as one page that opens offline; `-` is stdout.
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    overwrite: Overwrite,
}

fn parse_alignment(text: &str) -> Result<Alignment, String> {
    match (text, text.strip_prefix("event:")) {
        ("start", _) => Ok(Alignment::Start),
        ("best", _) => Ok(Alignment::Best),
        (_, Some(event)) if !event.is_empty() => Ok(Alignment::Event(event.to_owned())),
        _ => Err(format!("found {text:?}, expected start, best, or event:TEXT")),
    }
}

pub(super) fn run(args: &CompareArgs) -> anyhow::Result<End> {
    let outputs = args.overwrite.outputs_beside(&args.recordings, args.json)?;
    let html = place(&outputs, args.html.as_deref(), "--html")?;
    let names = names(&args.recordings);
    let read =
        |(path, name): (&PathBuf, String)| Ok(Flown { name, recording: read_recording(path)? });
    let flights =
        args.recordings.iter().zip(names).map(read).collect::<anyhow::Result<Vec<_>>>()?;
    let comparison = compare(&flights, &args.align)?;
    if let Some(html) = html {
        html.write(page(&flights, &comparison).as_bytes())?;
    }
    print(&outputs, |out| {
        if args.json {
            Ok(writeln!(out, "{}", serde_json::to_string(&comparison)?)?)
        } else {
            Ok(print_comparison(out, &comparison)?)
        }
    })?;
    Ok(End::Passed)
}

/// The stems of the files, or their paths where two stems are equal.
fn names(paths: &[PathBuf]) -> Vec<String> {
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let of = |path: &PathBuf| {
        let alone = paths.iter().filter(|other| stem(other) == stem(path)).count() == 1;
        if alone { stem(path) } else { path.display().to_string() }
    };
    paths.iter().map(of).collect()
}

fn print_comparison(out: &mut dyn Write, comparison: &Comparison) -> io::Result<()> {
    for pair in &comparison.others {
        let Pair { name, offset_s, overlap_s, facts, settings, metrics, signals } = pair;
        writeln!(
            out,
            "{name} beside {}: both flew for {overlap_s:.2} s, {offset_s:+.2} s added to the times of {name}",
            comparison.first
        )?;
        for difference in facts.iter().chain(settings.iter().flatten()) {
            writeln!(out, "  differs: {difference}")?;
        }
        if settings.is_none() {
            writeln!(out, "  settings are not compared: one of the recordings has no scenario")?;
        }
        print_rows(out, "whole flight", metrics, [name, &comparison.first])?;
        writeln!(out, "  {:28} {:>12} {:>12} {:>12}", "while both fly", "rms", "largest", "at s")?;
        for apart in signals {
            writeln!(
                out,
                "  {:28} {:12.4} {:+12.4} {:12.2}",
                apart.signal, apart.rms, apart.largest, apart.at_s
            )?;
        }
    }
    Ok(())
}
