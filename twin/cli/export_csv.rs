//! `twin export csv`.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use twin_core::notation::{Coords, N, ROWS};
use twin_core::tick::Tick;
use twin_foreign::OpenedFlight;
use twin_foreign::Shadow;
use twin_record::read_recording;

use super::End;

#[derive(Args)]
pub(super) struct CsvArgs {
    /// A recording of this program, or of a real flight (MCAP, ULog), which is flown in shadow.
    file: PathBuf,
    /// Where to write it [default: standard output].
    #[arg(long, short, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Which messages mean what, as for `twin mirror`.
    #[arg(long, value_name = "TOPICS.toml")]
    map: Option<String>,
}

/// One group of eight columns: stem and where its numbers are; the flag says that they need a known residual.
type Group = (&'static str, bool, fn(&Tick) -> Coords);

const GROUPS: [Group; 8] = [
    ("chi", false, |tick| tick.measurement.chi),
    ("chi_dot", false, |tick| tick.measurement.chi_dot),
    ("chi_ddot", true, |tick| tick.measurement.chi_ddot),
    ("tau_applied", true, |tick| tick.measurement.tau_applied),
    ("residual", true, |tick| tick.residual),
    ("r_hat_prior", true, |tick| tick.adapted.r_hat_prior),
    ("r_hat", true, |tick| tick.adapted.r_hat),
    ("innovation", true, |tick| tick.adapted.innovation),
];

pub(super) fn run(args: &CsvArgs) -> anyhow::Result<End> {
    let mut out: Box<dyn Write> = match &args.output {
        Some(path) => Box::new(BufWriter::new(
            File::create(path).with_context(|| format!("{}: cannot be written", path.display()))?,
        )),
        None => Box::new(BufWriter::new(std::io::stdout().lock())),
    };
    let written = write(args, &mut out).and_then(|rows| {
        out.flush()?;
        Ok(rows)
    });
    match written {
        Ok(rows) => {
            eprintln!("{rows} ticks, {} columns; SI units, empty is unknown", columns().len());
            Ok(End::Passed)
        }
        // A reader that has seen enough is no failure.
        Err(error) if is_closed_pipe(&error) => Ok(End::Passed),
        Err(error) => Err(error),
    }
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<std::io::Error>();
    io.is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}

fn columns() -> Vec<String> {
    let rows = GROUPS.iter().flat_map(|(stem, ..)| ROWS.map(|row| format!("{stem}.{row}")));
    ["tick", "t_s"].map(str::to_owned).into_iter().chain(rows).chain(["reset".to_owned()]).collect()
}

/// The number of ticks written.
fn write(args: &CsvArgs, out: &mut dyn Write) -> anyhow::Result<usize> {
    let all = ([true; N], [true; N]);
    let opened = OpenedFlight::open(&args.file, args.map.as_deref())?;
    writeln!(out, "{}", columns().join(","))?;
    if opened.is_own() {
        let ticks = read_recording(&args.file)?.ticks;
        for tick in &ticks {
            writeln!(out, "{}", line(tick, &all))?;
        }
        return Ok(ticks.len());
    }
    let shadow = Shadow::of(&opened);
    let mut flight = shadow.flight(0, shadow.tuning()).context("no tick to fly")?;
    for index in 0..shadow.ticks() {
        let tick = flight.tick();
        writeln!(out, "{}", line(&tick, &shadow.film().known(index)))?;
    }
    Ok(shadow.ticks())
}

/// A line; `known` says per row whether coordinate and residual are.
fn line(tick: &Tick, (coordinate, residual): &([bool; N], [bool; N])) -> String {
    let mut cells = vec![tick.index.to_string(), tick.measurement.t_s.to_string()];
    for (_, of_residual, take) in GROUPS {
        let (values, known) = (take(tick), if of_residual { residual } else { coordinate });
        let cell = |row: usize| {
            let value = Some(values[row]).filter(|v| known[row] && v.is_finite());
            value.map_or_else(String::new, |v| v.to_string())
        };
        cells.extend((0..N).map(cell));
    }
    cells.push(u8::from(tick.adapted.reset).to_string());
    cells.join(",")
}
