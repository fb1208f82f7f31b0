//! `twin diff`: compares two recordings tick by tick.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use twin_record::{Outputs, Recording, read_recording};
use twin_scenario::suite::diff::{Difference, diff};

use super::{End, print};

#[derive(Args)]
pub(super) struct DiffArgs {
    /// A recording.
    a: PathBuf,
    /// The recording to compare it with.
    b: PathBuf,
    /// Most channels in the table.
    #[arg(long, default_value_t = 20)]
    rows: usize,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &DiffArgs) -> anyhow::Result<End> {
    let (a, b) = (read_recording(&args.a)?, read_recording(&args.b)?);
    let mut found = diff(&a.ticks, &b.ticks);
    let end = if found.none() { End::Passed } else { End::Failed };
    let all = found.channels.len();
    found.channels.truncate(args.rows);
    print(&Outputs::default(), |out| {
        if args.json {
            writeln!(out, "{}", serde_json::to_string(&found)?)?;
        } else {
            print_metadata(out, &a, &b)?;
            print_difference(out, &found, all)?;
        }
        Ok(())
    })?;
    Ok(end)
}

/// The facts about the two flights that differ.
fn print_metadata(out: &mut dyn Write, a: &Recording, b: &Recording) -> io::Result<()> {
    for key in ["scenario", "seed", "gains", "version", "git", "kernel", "verdict"] {
        let [x, y] = [a, b].map(|recording| recording.metadata.get(key).map_or("", String::as_str));
        if x != y {
            writeln!(out, "{key}: {x} | {y}")?;
        }
    }
    Ok(())
}

fn print_difference(out: &mut dyn Write, found: &Difference, all: usize) -> io::Result<()> {
    let [a, b] = found.ticks;
    if found.none() {
        writeln!(out, "equal: {a} ticks")?;
        return Ok(());
    }
    writeln!(
        out,
        "{} of {} ticks differ; the flights have {a} and {b} ticks",
        found.unequal, found.compared
    )?;
    let Some(first) = &found.first else { return Ok(()) };
    writeln!(
        out,
        "the first difference is at tick {} ({:.2} s): {} is {} | {}",
        first.tick, first.t_s, first.channel, first.values[0], first.values[1]
    )?;
    writeln!(
        out,
        "\n{:>12} {:>9}  channel, values (largest {} of {all})",
        "difference",
        "at s",
        found.channels.len()
    )?;
    for row in &found.channels {
        writeln!(
            out,
            "{:12.4e} {:9.2}  {}: {} | {}",
            row.largest, row.at_s, row.channel, row.values[0], row.values[1]
        )?;
    }
    Ok(())
}
