//! `twin mirror`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use clap::Args;
use twin::mirror::{OpenedFlight, Recorder, RecordingEnd, RecordingInfo, stand_in};
use twin::residual::PredictorInfo;
use twin::scenario::{Shadow, ShadowReport, shadow};
use twin::server::{MirrorOptions, serve_mirror};

use super::End;
use super::fly::{Speed, parse_speed};

#[derive(Args)]
pub(super) struct MirrorArgs {
    /// MCAP file of a real flight; it may be cut off or damaged.
    file: PathBuf,
    /// No server: read the flight to its end and print what was found.
    #[arg(long)]
    headless: bool,
    /// Print exactly one JSON object on stdout (with --headless).
    #[arg(long, requires = "headless")]
    json: bool,
    /// Record the flight with residuals and predictions as MCAP (with --headless).
    #[arg(long, value_name = "FILE.mcap", requires = "headless")]
    record: Option<PathBuf>,
    /// Which messages mean what: a TOML file, or a shipped map (`acsl_x8`, `crazyflie`, `px4_arm`) [default: recognised].
    #[arg(long, value_name = "TOPICS.toml")]
    map: Option<String>,
    /// Seconds of the recording per second, or `max`.
    #[arg(long, default_value = "1", conflicts_with = "headless", value_parser = parse_speed)]
    rate: Speed,
    /// Start at this time of the recording, s.
    #[arg(long, default_value_t = 0.0, conflicts_with = "headless")]
    start_offset: f64,
    /// Wait for an operator before the first tick.
    #[arg(long, conflicts_with = "headless")]
    start_paused: bool,
    /// Port of the console; 0 takes any free one.
    #[arg(long, default_value_t = 8080, conflicts_with = "headless")]
    port: u16,
    /// Address to listen on; loopback only.
    #[arg(long, default_value = "127.0.0.1", conflicts_with = "headless")]
    host: String,
    /// Folder of the stock viewers [default: where `twin viewers fetch` puts them].
    #[arg(long, value_name = "DIR", conflicts_with = "headless")]
    viewer_dir: Option<PathBuf>,
    /// Serve Foxglove on this port too (8765 is its default); any page in the browser can then watch, pause and seek.
    #[arg(long, value_name = "PORT", conflicts_with = "headless")]
    foxglove_port: Option<u16>,
}

pub(super) fn run(args: &MirrorArgs) -> anyhow::Result<End> {
    let opened = OpenedFlight::open(&args.file, args.map.as_deref())?;
    for problem in &opened.survey.container.problems {
        eprintln!("{}: {problem}", args.file.display());
    }
    if !args.headless {
        serve_mirror(MirrorOptions {
            opened,
            host: args.host.clone(),
            port: args.port,
            speed: args.rate.0,
            start_s: args.start_offset,
            start_paused: args.start_paused,
            viewer_dir: args.viewer_dir.clone().or_else(super::viewers::default_folder),
            foxglove_port: args.foxglove_port,
        })?;
        return Ok(End::Passed);
    }
    let report = fly(&opened, args.record.as_deref())?;
    if args.json {
        println!("{}", json(&opened, &report));
    } else {
        print(&opened, &report);
    }
    Ok(End::Passed)
}

/// Flies in shadow to the end, and records it if that is asked for.
fn fly(opened: &OpenedFlight, record: Option<&Path>) -> anyhow::Result<ShadowReport> {
    let mut recorder = match record {
        Some(path) => Some(Recorder::create(path, &recording_info(opened)?)?),
        None => None,
    };
    let mut trouble = None;
    let report = shadow(&opened.recorded, opened.map.vehicle.inertia_kg_m2, &mut |tick| {
        if let Some(recorder) = &mut recorder
            && trouble.is_none()
        {
            trouble = recorder.record(Arc::new(tick.clone())).err();
        }
    })
    .with_context(|| format!("{}: no tick to fly", opened.path.display()))?;
    if let Some(trouble) = trouble {
        return Err(trouble.into());
    }
    if let Some(recorder) = recorder {
        let state_hash = u64::from_str_radix(&report.state_hash, 16)?;
        let verdict = "mirrored in shadow".to_owned();
        let written = recorder.finish(RecordingEnd { state_hash, verdict })?;
        eprintln!("{} ticks recorded", written.ticks);
    }
    Ok(report)
}

fn recording_info(opened: &OpenedFlight) -> anyhow::Result<RecordingInfo> {
    let shadow = Shadow::new(&opened.recorded, opened.map.vehicle.inertia_kg_m2);
    Ok(RecordingInfo {
        scenario: format!("mirror of {}", opened.name()),
        scenario_toml: String::new(),
        seed: 0,
        gains_json: serde_json::to_string(shadow.tuning())?,
        urdf: String::new(),
        // Nothing is known of its actuators.
        limits_json: "{}".to_owned(),
        predictor_json: serde_json::to_string(&PredictorInfo {
            scale: *shadow.scale(),
            ..PredictorInfo::default()
        })?,
        kernel: PredictorInfo::default().kernel,
        scene: stand_in(),
        joint_names: opened
            .signals
            .joints
            .as_ref()
            .map_or_else(Vec::new, |(names, _)| names.clone()),
    })
}

fn json(opened: &OpenedFlight, report: &ShadowReport) -> serde_json::Value {
    let OpenedFlight { path, survey, map, map_name, signals, recorded } = opened;
    let empty: Vec<&str> = survey
        .channels
        .iter()
        .filter(|info| info.messages == 0)
        .map(|info| info.topic.as_str())
        .collect();
    serde_json::json!({
        "file": path.display().to_string(),
        "map": map_name,
        "vehicle": map.vehicle,
        "mass_in_use_kg": recorded.mass_kg,
        "forces_are_per_kilogram": opened.per_kilogram(),
        "container": survey.container,
        "ambiguous_schemas": survey.ambiguous_schemas,
        "empty_channels": empty,
        "used": signals.used,
        "joints": signals.joints.as_ref().map(|(names, _)| names),
        "notes": signals.notes,
        "effort": recorded.effort,
        "acceleration": { "translation": recorded.acceleration[0], "rotation": recorded.acceleration[1] },
        "shadow": report,
    })
}

fn print(opened: &OpenedFlight, report: &ShadowReport) {
    let OpenedFlight { path, map_name, signals, recorded, .. } = opened;
    println!("{} (map {map_name})", path.display());
    for used in &signals.used {
        println!(
            "  {:<17} {} {:.1} Hz, {} gaps, longest {:.3} s, clock {:?}, latency {:+.1} ms; left out: {} twice, {} back in time, {} not finite, {} repeated, {} merged",
            format!("{:?}", used.quantity),
            used.topic,
            used.timing.rate_hz,
            used.timing.gaps,
            used.timing.longest_gap_s,
            used.time.clock,
            used.time.latency_ms,
            used.timing.duplicate,
            used.timing.backwards,
            used.timing.not_finite,
            used.timing.repeated,
            used.timing.merged,
        );
    }
    for note in &signals.notes {
        println!("  note: {note}");
    }
    if opened.per_kilogram() {
        println!("  the mass is unknown: forces are per kilogram");
    }
    println!(
        "  acceleration of translation from {:?}, of rotation from {:?}",
        recorded.acceleration[0], recorded.acceleration[1]
    );
    println!("  {}", opened.force_sentence());
    print_shadow(report);
}

fn print_shadow(report: &ShadowReport) {
    println!(
        "  {} ticks, {:.1} s, {} in the air, {} without a residual there",
        report.ticks, report.flight_s, report.airborne_ticks, report.held_ticks
    );
    for row in &report.scored.rows {
        match &row.residual {
            None => println!("  r {:6} unknown", row.row),
            Some(r) => println!(
                "  r {:6} {:9.4} +- {:.4} {} ({:.4} .. {:.4}), known {:.0} %",
                row.row,
                r.mean,
                r.std,
                r.unit,
                r.min,
                r.max,
                100.0 * row.residual_known
            ),
        }
    }
    println!("  predictor: {}; resets at {:?} s", report.predictor, report.resets_s);
    for horizon in &report.scored.prediction {
        let text = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.4}"));
        println!(
            "  j = {}: RMSE {} z, persistence {} z",
            horizon.j,
            text(horizon.rmse_z),
            text(horizon.persistence_rmse_z)
        );
    }
}
