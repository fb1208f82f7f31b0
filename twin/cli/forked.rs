//! `twin fly --headless --fork-at`: a flight and its forks, with their differences.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use serde::Serialize;
use twin_core::tick::Tick;
use twin_input::interruption;
use twin_record::output::{Output, note};
use twin_record::{Outputs, Recorder, RecordingEnd, RecordingStatus};
use twin_scenario::differences::Difference;
use twin_scenario::fork::{Fork, Forked, Plan, fly_forked, plans};
use twin_scenario::run::event_lines;
use twin_scenario::{Report, Row, Scenario};

use super::fly::{self, FlyArgs, print_report, recorder, told};
use super::{End, print};

/// Flies the scenario and the forks that the flags ask for.
pub(super) fn run(args: &FlyArgs) -> anyhow::Result<End> {
    let (_, scenario) = &fly::scenario(args)?;
    let outputs = args.overwrite.outputs();
    outputs.protect(scenario.input_files());
    let plans = plans(scenario, &args.orders.forks)?;
    let flights: Vec<&Scenario> =
        std::iter::once(scenario).chain(plans.iter().map(Plan::scenario)).collect();
    let mut recorders = recorders(args.record.as_deref(), &flights, &outputs)?;
    let places = places(args.scenario_out.as_deref(), plans.len(), &outputs)?;
    let flown = fly_forked(scenario, plans, &mut |flights, tick| {
        if !args.json {
            tell_events(flights, tick);
        }
        let tick = Arc::new(tick.clone());
        for flight in flights {
            if let Some(recorder) = recorders.get_mut(*flight) {
                // A recording that fails does not end the flight; its status tells below.
                let _ = recorder.record(Arc::clone(&tick));
            }
        }
    })
    .with_context(|| scenario.file.display().to_string())?;
    let recordings = close(recorders, &flown)?;
    let scenarios = write_scenarios(places, &flown.forks)?;
    // Every recording is told, also after one that failed.
    let whole = recordings.iter().filter(|recording| !told(recording)).count() == 0;
    let json = json(&flown, &recordings, &scenarios);
    print(&outputs, |out| {
        if args.json {
            Ok(writeln!(out, "{}", serde_json::to_string(&json)?)?)
        } else {
            Ok(print_forked(out, &flown, &scenarios)?)
        }
    })?;
    Ok(match interruption::requested() {
        _ if !whole => End::Failed,
        Some(signal) if flown.was_interrupted() => End::Interrupted(signal),
        _ if flown.parent.passed => End::Passed,
        _ => End::Failed,
    })
}

/// The events of a tick on stderr, once, with the flights that have it.
fn tell_events(flights: &[usize], tick: &Tick) {
    let flight = flights.first().copied().unwrap_or_default();
    let whose = if flight == 0 { String::new() } else { format!("fork {flight}: ") };
    event_lines(tick).for_each(|line| note(format_args!("{whose}{line}")));
}

/// `path` with `-fork-NUMBER` behind its stem.
fn numbered(path: &Path, number: usize) -> PathBuf {
    let text =
        |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    path.with_file_name(format!(
        "{}-fork-{number}.{}",
        text(path.file_stem()),
        text(path.extension())
    ))
}

/// The recordings of the flight (at `path`) and of its forks (beside it); none without a path.
fn recorders(
    path: Option<&Path>,
    flights: &[&Scenario],
    outputs: &Outputs,
) -> anyhow::Result<Vec<Recorder>> {
    let Some(path) = path else { return Ok(Vec::new()) };
    let name = |flight: usize| if flight == 0 { path.to_owned() } else { numbered(path, flight) };
    let each = flights.iter().enumerate();
    each.map(|(flight, scenario)| recorder(scenario, &name(flight), outputs)).collect()
}

/// Finishes the recordings.
fn close(recorders: Vec<Recorder>, flown: &Forked) -> anyhow::Result<Vec<RecordingStatus>> {
    let mut all = Vec::new();
    // A fork that was not flown, because a signal came, ends as its parent did.
    let reports =
        flown.forks.iter().map(|fork| &fork.report).chain(std::iter::repeat(&flown.parent));
    for (recorder, report) in
        recorders.into_iter().zip(std::iter::once(&flown.parent).chain(reports))
    {
        let state_hash = u64::from_str_radix(&report.state_hash, 16)?;
        let verdict = format!("{}: {}", report.verdict, report.reason);
        all.push(recorder.close(RecordingEnd { state_hash, verdict }));
    }
    Ok(all)
}

/// The files of the scenarios that repeat the forks: `path` for one fork, numbered names for several.
fn places(path: Option<&Path>, forks: usize, outputs: &Outputs) -> anyhow::Result<Vec<Output>> {
    let Some(path) = path else { return Ok(Vec::new()) };
    let name = |number: usize| if forks == 1 { path.to_owned() } else { numbered(path, number) };
    (1..=forks).map(|number| Ok(outputs.reserve(&name(number), "--scenario-out")?)).collect()
}

/// Writes the scenarios; returns their paths.
fn write_scenarios(places: Vec<Output>, forks: &[Fork]) -> anyhow::Result<Vec<String>> {
    let mut paths = Vec::new();
    for (place, fork) in places.into_iter().zip(forks) {
        let folder = place.path().parent().map_or_else(PathBuf::new, Path::to_owned);
        let scenario = fork.scenario.for_folder(&folder)?;
        let text = toml::to_string(&scenario.settings)?;
        let head = format!(
            "# Repeats a fork of {} at {} s; its flight ends with the state hash {}.\n",
            scenario.name, fork.order.at_s, fork.report.state_hash
        );
        paths.push(place.path().display().to_string());
        place.write((head + &text).as_bytes())?;
    }
    Ok(paths)
}

/// What `--json` prints.
#[derive(Serialize)]
struct Json<'a> {
    parent: &'a Report,
    #[serde(skip_serializing_if = "Option::is_none")]
    recording: Option<&'a RecordingStatus>,
    forks: Vec<ForkJson<'a>>,
}

/// A fork in [`Json`].
#[derive(Serialize)]
struct ForkJson<'a> {
    at_s: f64,
    set: &'a [String],
    changed: &'a [Difference],
    report: &'a Report,
    /// Metrics from the fork on.
    differences: &'a [Row],
    #[serde(skip_serializing_if = "Option::is_none")]
    recording: Option<&'a RecordingStatus>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scenario: Option<&'a String>,
}

fn json<'a>(
    flown: &'a Forked,
    recordings: &'a [RecordingStatus],
    scenarios: &'a [String],
) -> Json<'a> {
    let forks = flown.forks.iter().enumerate().map(|(index, fork)| ForkJson {
        at_s: fork.order.at_s,
        set: &fork.order.set,
        changed: &fork.changed,
        report: &fork.report,
        differences: &fork.rows,
        recording: recordings.get(index + 1),
        scenario: scenarios.get(index),
    });
    Json { parent: &flown.parent, recording: recordings.first(), forks: forks.collect() }
}

fn print_forked(out: &mut dyn Write, flown: &Forked, scenarios: &[String]) -> io::Result<()> {
    print_report(out, &flown.parent)?;
    for (index, fork) in flown.forks.iter().enumerate() {
        let Fork { order, changed, report, rows, .. } = fork;
        writeln!(
            out,
            "\nfork {} at {} s: {:?}: {}",
            index + 1,
            order.at_s,
            report.verdict,
            report.reason
        )?;
        writeln!(out, "  {:.1} s flown, state hash {}", report.flight_s, report.state_hash)?;
        if changed.is_empty() {
            writeln!(out, "  nothing changed")?;
        }
        for difference in changed {
            writeln!(out, "  changed: {difference}")?;
        }
        if let Some(path) = scenarios.get(index) {
            writeln!(out, "  repeated by {path}")?;
        }
        print_rows(out, "from the fork on", rows, ["fork", "flight"])?;
    }
    Ok(())
}

/// The metrics of two flights side by side: `names` are those of the second flight and of the first.
pub(super) fn print_rows(
    out: &mut dyn Write,
    title: &str,
    rows: &[Row],
    [second, first]: [&str; 2],
) -> io::Result<()> {
    let cell =
        |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.4}"));
    writeln!(out, "  {title:28} {second:>12} {first:>12} {:>12}", "difference")?;
    for Row { metric, value, parent, difference, judgement } in rows {
        let [value, parent] = [*value, *parent].map(cell);
        let difference = difference.map_or_else(|| "-".to_owned(), |value| format!("{value:+.4}"));
        let word = judgement.word();
        writeln!(
            out,
            "{}",
            format!("  {metric:28} {value:>12} {parent:>12} {difference:>12}  {word}").trim_end()
        )?;
    }
    Ok(())
}
