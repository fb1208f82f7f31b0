//! `twin fly`.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use twin::scenario::{Report, Scenario, fly, run::event_lines};

use super::{End, Overrides, default_scenario};

#[derive(Args, Clone)]
pub(super) struct FlyArgs {
    /// Scenario file [default: scenarios/a_300g_slow.toml].
    scenario: Option<PathBuf>,
    /// No server: fly as fast as the machine can, print the verdict, exit 0 if it is the expected one.
    #[arg(long)]
    headless: bool,
    /// Print exactly one JSON object on stdout (with --headless).
    #[arg(long, requires = "headless")]
    json: bool,
    /// Seed instead of the scenario's.
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    overrides: Overrides,
}

pub(super) fn run(args: &FlyArgs) -> anyhow::Result<End> {
    let file = args.scenario.clone().unwrap_or_else(default_scenario);
    let mut overrides = args.overrides.set.clone();
    overrides.extend(args.seed.map(|seed| format!("seed={seed}")));
    let scenario = Scenario::load(&file, &overrides)?;
    headless(&scenario, args)
}

/// Flies to the end; events on stderr as they happen, the verdict on stdout.
fn headless(scenario: &Scenario, args: &FlyArgs) -> anyhow::Result<End> {
    #[allow(clippy::disallowed_methods, reason = "the real-time factor needs a clock; the flight does not see it")]
    let started = std::time::Instant::now();
    let mut report = fly(scenario, &mut |tick| {
        if !args.json {
            event_lines(tick).for_each(|line| eprintln!("{line}"));
        }
    })
    .with_context(|| scenario.file.display().to_string())?;
    report.real_time_factor = Some(report.flight_s / started.elapsed().as_secs_f64().max(1e-9));
    if args.json {
        println!("{}", serde_json::to_string(&report)?);
    } else {
        print_report(&report);
    }
    Ok(if report.passed { End::Passed } else { End::Failed })
}

fn print_report(report: &Report) {
    let factor = report.real_time_factor.unwrap_or(0.0);
    println!("{} (seed {}): {:?}: {}", report.scenario, report.seed, report.verdict, report.reason);
    println!("  {:.1} s flown, {factor:.1} x real time, state hash {}", report.flight_s, report.state_hash);
    for (name, value) in &report.metrics {
        println!("  {name:28} {value:10.4}");
    }
    for bound in &report.broken_bounds {
        println!("  BOUND BROKEN: {bound}");
    }
}
