//! `twin diff`: compares two recordings tick by tick.

use std::path::PathBuf;

use clap::Args;
use twin_record::read_recording;
use twin_scenario::suite::diff::{Difference, diff};

use super::End;

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
    if args.json {
        println!("{}", serde_json::to_string(&found)?);
        return Ok(end);
    }
    for key in ["scenario", "seed", "gains", "version", "git", "kernel", "verdict"] {
        let [x, y] =
            [&a, &b].map(|recording| recording.metadata.get(key).map_or("", String::as_str));
        if x != y {
            println!("{key}: {x} | {y}");
        }
    }
    print(&found, all);
    Ok(end)
}

fn print(found: &Difference, all: usize) {
    let [a, b] = found.ticks;
    if found.none() {
        println!("equal: {a} ticks");
        return;
    }
    println!(
        "{} of {} ticks differ; the flights have {a} and {b} ticks",
        found.unequal, found.compared
    );
    let Some(first) = &found.first else { return };
    println!(
        "the first difference is at tick {} ({:.2} s): {} is {} | {}",
        first.tick, first.t_s, first.channel, first.values[0], first.values[1]
    );
    println!(
        "\n{:>12} {:>9}  channel, values (largest {} of {all})",
        "difference",
        "at s",
        found.channels.len()
    );
    for row in &found.channels {
        println!(
            "{:12.4e} {:9.2}  {}: {} | {}",
            row.largest, row.at_s, row.channel, row.values[0], row.values[1]
        );
    }
}
