//! `twin evaluate l1`: a sweep of the parameters of the L1 controller.

use std::path::PathBuf;

use clap::Args;
use twin_input::interruption;
use twin_lab::evaluate::Sheet;
use twin_lab::evaluate::sheet::figure;
use twin_record::output::note;
use twin_scenario::table::{Job, Line, condense, fly_all};

use super::output::{Output, inputs_of};
use crate::cli::{End, Overrides, print};

#[derive(Args)]
pub(super) struct L1Args {
    /// Scenarios whose paths are flown with the payload in the gripper from the start.
    #[arg(default_values = ["scenarios/a_500g_fast.toml", "scenarios/b_300g_slow.toml"])]
    scenarios: Vec<PathBuf>,
    /// Poles `-A_s`, 1/s.
    #[arg(long, value_delimiter = ',', default_value = "0.1,1,5,20")]
    poles: Vec<f64>,
    /// Corners of the low-pass, rad/s: those of x y z, a colon, and those of the other coordinates.
    #[arg(long, value_delimiter = ',', default_value = "4:8,12:48,20:80,40:160", value_parser = parse_corners)]
    cutoffs: Vec<[f64; 2]>,
    /// Gain preset.
    #[arg(long, default_value = "tuned")]
    preset: String,
    /// Flights at a time [default: one per core].
    #[arg(long)]
    jobs: Option<usize>,
    #[command(flatten)]
    pub(super) output: Output,
    #[command(flatten)]
    overrides: Overrides,
}

fn parse_corners(text: &str) -> Result<[f64; 2], String> {
    let parsed = text.split_once(':').and_then(|(a, b)| Some([a.parse().ok()?, b.parse().ok()?]));
    parsed.ok_or_else(|| format!("found {text:?}, expected two corners such as 2:4, rad/s"))
}

pub(super) fn run(args: &L1Args) -> anyhow::Result<End> {
    let places = args.output.reserve(inputs_of(&args.scenarios))?;
    let mut jobs = Vec::new();
    for pole in &args.poles {
        for [force, moment] in &args.cutoffs {
            for file in &args.scenarios {
                let mut overrides = super::PATH_ALONE.map(str::to_owned).to_vec();
                overrides.extend([
                    "controller.kind=l1".to_owned(),
                    format!("gains.preset={}", args.preset),
                    format!("controller.l1.pole_per_s={pole:?}"),
                    format!("controller.l1.cutoff_rad_s=[{force:?}, {moment:?}]"),
                ]);
                overrides.extend(args.overrides.set.iter().cloned());
                let row = format!("A_s -{pole}  ω_c {force}:{moment}");
                jobs.push(Job { row, file: file.clone(), overrides });
            }
        }
    }
    let threads =
        args.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let outcomes = fly_all(&jobs, threads, None, &|outcome| match &outcome.result {
        Ok(report) => note(format_args!("{} {}: {}", outcome.row, report.scenario, report.verdict)),
        Err(error) => note(format_args!("{}: {error}", outcome.row)),
    });
    interruption::check()?;
    let lines = condense(&outcomes);
    let mut sheet = Sheet::new(["row", "scenario", "rms e8, m and rad", "ended"]);
    sheet.rows.extend(lines.iter().map(|line| cells(line).to_vec()));
    let outputs = places.write_pictures("L1: poles and corners", &sheet, || Ok(String::new()))?;
    print(&outputs, |out| {
        let command = super::command();
        if args.output.json {
            let value = serde_json::json!({ "table": "l1", "command": command, "lines": lines });
            return Ok(writeln!(out, "{value}")?);
        }
        writeln!(out, "{:28} {:14} {:>9}  verdict", "rms e8, m and rad", "scenario", "e8")?;
        for line in &lines {
            let [row, scenario, value, ended] = cells(line);
            writeln!(out, "{row:28} {scenario:14} {value:>9}  {ended}")?;
        }
        Ok(writeln!(out, "\n{command}")?)
    })?;
    Ok(End::Passed)
}

fn cells(line: &Line) -> [String; 4] {
    let value = line.values.get("rms_error_e8_mean").copied();
    let ended = line.other_verdicts.keys().next().map_or("completed", String::as_str);
    [line.row.clone(), line.scenario.clone(), figure(value, 3), ended.to_owned()]
}
