//! `twin export csv`.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use twin_core::notation::{COORDINATE_NAMES, KnownCoords, N};
use twin_core::tick::Tick;
use twin_foreign::OpenedFlight;
use twin_foreign::Shadow;
use twin_input::interruption;
use twin_record::output::note;
use twin_record::read_recording;

use super::{End, Overwrite};

#[derive(Args)]
pub(super) struct CsvArgs {
    /// A recording of this program, or of a real flight (MCAP, ULog), which is flown in shadow.
    file: PathBuf,
    /// The table, in an existing folder; `-` is stdout [default: stdout].
    #[arg(long, short, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Which messages mean what, as for `twin mirror`.
    #[arg(long, value_name = "TOPICS.toml")]
    map: Option<String>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// One group of eight columns, one per coordinate: name stem and how to read its values from a tick.
type Group = (&'static str, fn(&Tick) -> KnownCoords);

const GROUPS: [Group; 8] = [
    ("chi", |tick| tick.measurement.chi),
    ("chi_dot", |tick| tick.measurement.chi_dot),
    ("chi_ddot", |tick| tick.measurement.chi_ddot),
    ("tau_applied", |tick| tick.measurement.tau_applied),
    ("residual", |tick| tick.residual),
    ("r_hat_prior", |tick| tick.adapted.r_hat_prior),
    ("r_hat", |tick| tick.adapted.r_hat),
    ("innovation", |tick| tick.adapted.innovation),
];

pub(super) fn run(args: &CsvArgs) -> anyhow::Result<End> {
    let outputs = args.overwrite.outputs();
    outputs.protect([&args.file]);
    outputs.protect(&args.map);
    let path = args.output.as_deref().unwrap_or_else(|| Path::new("-"));
    let mut out = outputs.reserve(path, "--output")?.open()?;
    let rows = write(args, &mut out)?;
    out.finish()?;
    note(format_args!("{rows} ticks, {} columns; SI units, empty is unknown", columns().len()));
    Ok(End::Passed)
}

fn columns() -> Vec<String> {
    let rows =
        GROUPS.iter().flat_map(|(stem, ..)| COORDINATE_NAMES.map(|row| format!("{stem}.{row}")));
    ["tick", "t_s"].map(str::to_owned).into_iter().chain(rows).chain(["reset".to_owned()]).collect()
}

/// Writes the table and returns the number of ticks.
fn write(args: &CsvArgs, out: &mut dyn Write) -> anyhow::Result<usize> {
    let opened = OpenedFlight::open(&args.file, args.map.as_deref())?;
    writeln!(out, "{}", columns().join(","))?;
    if opened.is_own() {
        let ticks = read_recording(&args.file)?.ticks;
        for tick in &ticks {
            interruption::check()?;
            writeln!(out, "{}", line(tick))?;
        }
        return Ok(ticks.len());
    }
    let shadow = Shadow::of(&opened);
    let mut flight = shadow.flight(0, shadow.tuning()).context("no tick to fly")?;
    for _ in 0..shadow.ticks() {
        interruption::check()?;
        writeln!(out, "{}", line(&flight.tick()))?;
    }
    Ok(shadow.ticks())
}

/// One line of the table. An unknown value, or one that is not a number, is an empty cell.
fn line(tick: &Tick) -> String {
    let mut cells = vec![tick.index.to_string(), tick.measurement.t_s.to_string()];
    for (_, take) in GROUPS {
        let values = take(tick);
        let cell = |row: usize| {
            let value = values.get(row).filter(|v| v.is_finite());
            value.map_or_else(String::new, |v| v.to_string())
        };
        cells.extend((0..N).map(cell));
    }
    cells.push(u8::from(tick.adapted.reset).to_string());
    cells.join(",")
}
