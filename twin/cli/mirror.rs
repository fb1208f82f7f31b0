//! `twin mirror`.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use twin_console::server::{AppOrigin, Limits, MirrorOptions, serve_mirror};
use twin_core::notation::TICK_S;
use twin_core::residual::PredictorInfo;
use twin_core::tick::Tick;
use twin_foreign::live::{From, is_address};
use twin_foreign::{Forecaster, Live, OpenedFlight, stand_in};
use twin_foreign::{Shadow, ShadowReport};
use twin_input::interruption::{self, Signal};
use twin_lab::evaluate::mirrored::FlightPicture;
use twin_plant::model::Packages;
use twin_record::output::note;
use twin_record::{Outputs, Recorder, RecordingEnd, RecordingInfo, RecordingStatus};
use twin_scenario::Verdict;

use super::fly::{Speed, parse_speed, told};
use super::mirror_beside as beside;
use super::mirror_report::{json, print_report};
use super::{End, Overwrite, print};

/// Time without data after which the program says what it waits for.
const TOLD: Duration = Duration::from_secs(5);

#[derive(Args)]
#[expect(clippy::struct_excessive_bools, reason = "flags of a command line")]
pub(super) struct MirrorArgs {
    /// MCAP or ULog file of a real flight, which may be cut off or damaged; or `ws://HOST:PORT` of a Foxglove WebSocket server.
    file: PathBuf,
    /// The file is still being written: watch it as it grows.
    #[arg(long, conflicts_with = "headless")]
    follow: bool,
    /// No server: read the flight to its end and print what was found.
    #[arg(long)]
    headless: bool,
    /// Print exactly one JSON object on stdout (with --headless).
    #[arg(long, requires = "headless")]
    pub(super) json: bool,
    /// Record the flight with residuals and predictions as MCAP (with --headless). If the file exists, the recording goes to
    /// FILE-2.mcap, FILE-3.mcap, …
    #[arg(long, value_name = "FILE.mcap", requires = "headless")]
    record: Option<PathBuf>,
    /// Draw thrust, residual and adapter over the flight as SVG, in an existing folder; `-` is stdout (with --headless).
    #[arg(long, value_name = "FILE.svg", requires = "headless")]
    plot: Option<PathBuf>,
    /// The twin that flies beside the recording (with --headless) [default: one rigid body of the mass and inertia that are known].
    #[arg(long, value_name = "FILE.urdf", requires = "headless")]
    urdf: Option<PathBuf>,
    /// Fly the twin from this time of the recording, s, and print how far it gets from the flight (with --headless).
    #[arg(long, value_name = "SECONDS", requires = "headless")]
    fly_from: Option<f64>,
    /// Which messages mean what: a TOML file, or a shipped map (`acsl_x8`, `crazyflie`, `px4_arm`) [default: recognised].
    #[arg(long, value_name = "TOPICS.toml")]
    map: Option<String>,
    /// Namespace of the vehicle to mirror, such as `/px4_1`, if the recording has several [default: the one that flies].
    #[arg(long, value_name = "/NAMESPACE", conflicts_with = "follow")]
    vehicle: Option<String>,
    /// Trained weights that predict, from `twin train`; they serve a vehicle only if they were trained on its flights [default: an
    /// autoregression that learns in flight].
    #[arg(long, value_name = "FILE.weights")]
    weights: Option<PathBuf>,
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
    /// Serve Foxglove on this port too (8765 is its default), for watching, pausing and seeking. Foxglove, Lichtblick, their desktop
    /// programs, pages of this machine, and programs may connect.
    #[arg(long, value_name = "PORT", conflicts_with = "headless")]
    foxglove_port: Option<u16>,
    /// Another page that may use the port for Foxglove, such as your own Lichtblick; may be given more than once.
    #[arg(long, value_name = "https://HOST[:PORT]", requires = "foxglove_port")]
    foxglove_origin: Vec<AppOrigin>,
    #[command(flatten)]
    overwrite: Overwrite,
}

pub(super) fn run(args: &MirrorArgs) -> anyhow::Result<End> {
    if let Some(from) = live(args)? {
        let forecaster = forecaster(args)?;
        let (live, opened) = hear(&from, args)?;
        let served = serve_mirror(options(args, opened, Some(live), forecaster))?;
        return Ok(End::Interrupted(served.signal));
    }
    let forecaster = forecaster(args)?;
    let opened = open(args)?;
    for problem in &opened.survey.container.problems {
        note(format_args!("{}: {problem}", args.file.display()));
    }
    if !args.headless {
        let served = serve_mirror(options(args, opened, None, forecaster))?;
        return Ok(End::Interrupted(served.signal));
    }
    headless(args, &opened, forecaster)
}

/// The predictor that is asked for.
fn forecaster(args: &MirrorArgs) -> anyhow::Result<Forecaster> {
    let Some(file) = &args.weights else { return Ok(Forecaster::default()) };
    let name = file.display().to_string();
    Forecaster::trained(super::read_weights(file)?, name.clone()).context(name)
}

/// Reads the flight to its end, and prints what was found.
fn headless(
    args: &MirrorArgs,
    opened: &OpenedFlight,
    forecaster: Forecaster,
) -> anyhow::Result<End> {
    let outputs = args.overwrite.outputs_beside([&args.file], args.json)?;
    outputs.protect(&args.map);
    outputs.protect(&args.weights);
    outputs.protect(args.urdf.iter().flat_map(|urdf| Packages::default().files(urdf)));
    let plot = args.plot.as_ref().map(|plot| outputs.reserve(plot, "--plot")).transpose()?;
    let shadow = Shadow::of(opened).with(forecaster);
    let twin = beside::twin(args.urdf.as_deref(), opened)?;
    let recorder = record(args.record.as_deref(), opened, &shadow, &outputs)?;
    let mut picture = plot.as_ref().map(|_| FlightPicture::new(opened.recorded.mass_kg));
    let (report, recording) = fly(opened, &shadow, recorder, picture.as_mut())?;
    let is_recorded = recording.as_ref().is_none_or(told);
    if let Some(signal) = interruption::requested() {
        if args.json {
            let found = interrupted(opened, &report, recording.as_ref(), signal)?;
            print(&outputs, |out| Ok(writeln!(out, "{found}")?))?;
        }
        return Ok(if is_recorded { End::Interrupted(signal) } else { End::Failed });
    }
    if let (Some(output), Some(picture)) = (plot, &picture) {
        output.write(picture.svg(&opened.name()).as_bytes())?;
    }
    let divergence = beside::Divergence::new(opened, &shadow, twin, args.fly_from)?;
    print(&outputs, |out| {
        if args.json {
            let mut found = json(opened, &report);
            found["divergence"] = divergence.json();
            if let Some(recording) = &recording {
                found["recording"] = serde_json::to_value(recording)?;
            }
            writeln!(out, "{found}")?;
        } else {
            print_report(out, opened, &report)?;
            divergence.print(out)?;
        }
        Ok(())
    })?;
    Ok(if is_recorded { End::Passed } else { End::Failed })
}

/// The JSON object of a flight that a signal ended: how far it came.
fn interrupted(
    opened: &OpenedFlight,
    report: &ShadowReport,
    recording: Option<&RecordingStatus>,
    signal: Signal,
) -> anyhow::Result<serde_json::Value> {
    let mut found = json(opened, report);
    found["verdict"] = serde_json::to_value(Verdict::Interrupted)?;
    found["reason"] = format!("{signal} at {:.2} s", report.flight_s).into();
    if let Some(recording) = recording {
        found["recording"] = serde_json::to_value(recording)?;
    }
    Ok(found)
}

/// Starts the recording at `path`, and tells its name if it is another.
fn record(
    path: Option<&Path>,
    opened: &OpenedFlight,
    shadow: &Shadow,
    outputs: &Outputs,
) -> anyhow::Result<Option<Recorder>> {
    let Some(path) = path else { return Ok(None) };
    let file = outputs.recording(path, "--record")?;
    if let Some(renamed) = file.renamed() {
        note(renamed);
    }
    let recorder = Recorder::start(file, &recording_info(opened, shadow)?)?;
    Ok(Some(recorder.for_flight_of(shadow.ticks() as f64 * TICK_S)))
}

fn options(
    args: &MirrorArgs,
    opened: OpenedFlight,
    live: Option<Live>,
    forecaster: Forecaster,
) -> MirrorOptions {
    MirrorOptions {
        opened,
        forecaster,
        host: args.host.clone(),
        port: args.port,
        speed: args.rate.0,
        // A live flight starts at its newest tick.
        start_s: if live.is_some() { f64::MAX } else { args.start_offset },
        live,
        start_paused: args.start_paused,
        viewer_dir: args.viewer_dir.clone().or_else(super::viewers::default_folder),
        foxglove_port: args.foxglove_port,
        foxglove_origins: args.foxglove_origin.clone(),
        limits: Limits::STANDARD,
    }
}

/// The source of a live flight; `None` for a finished recording.
fn live(args: &MirrorArgs) -> anyhow::Result<Option<From>> {
    let address = is_address(&args.file);
    anyhow::ensure!(
        !(address && args.headless),
        "{}: a stream has no end, so --headless cannot fly it to its end; leave --headless out, or mirror a recording",
        args.file.display()
    );
    if args.follow {
        // A file that is not there yet may appear; anything but a file never becomes a recording.
        let kind = twin_input::file::check_kind(&args.file);
        kind.with_context(|| format!("{}: cannot be followed", args.file.display()))?;
    }
    Ok(if address {
        Some(From::Socket(args.file.display().to_string()))
    } else {
        args.follow.then(|| From::File(args.file.clone()))
    })
}

/// Waits for the first pose and reports what is missing.
fn hear(from: &From, args: &MirrorArgs) -> anyhow::Result<(Live, OpenedFlight)> {
    let live = Live::listen(from, args.map.as_deref())?;
    loop {
        if let Some(opened) = live.wait(TOLD) {
            return Ok((live, opened));
        }
        live.news().iter().for_each(|text| note(format_args!("{text}")));
        interruption::check()?;
        note(format_args!("{}: waiting for a pose", live.name()));
    }
}

/// Opens the flight, with a progress bar if the whole file has to be read.
fn open(args: &MirrorArgs) -> anyhow::Result<OpenedFlight> {
    let bar = ProgressBar::no_length().with_style(
        ProgressStyle::with_template("{msg} [{wide_bar}] {bytes}/{total_bytes}, {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    bar.set_message("read whole, because it has no index of chunks");
    let (map, vehicle) = (args.map.as_deref(), args.vehicle.as_deref());
    let opened = OpenedFlight::open_vehicle(&args.file, map, vehicle, &mut |read, of| {
        bar.set_length(of);
        bar.set_position(read);
    });
    bar.finish_and_clear();
    Ok(opened?)
}

/// Flies in shadow to the end; records and draws the flight if asked to.
fn fly(
    opened: &OpenedFlight,
    shadow: &Shadow,
    mut recorder: Option<Recorder>,
    mut picture: Option<&mut FlightPicture>,
) -> anyhow::Result<(ShadowReport, Option<RecordingStatus>)> {
    let mut keep = |tick: &Tick| {
        if let Some(picture) = &mut picture {
            picture.add(tick);
        }
        if let Some(recorder) = &mut recorder {
            // A recording that fails does not end the flight; its status tells.
            let _ = recorder.record(Arc::new(tick.clone()));
        }
    };
    let report = shadow
        .fly(&mut keep)
        .with_context(|| format!("{}: no tick to fly", opened.path.display()))?;
    for text in shadow.playback().troubles() {
        note(format_args!("{}: {text}", opened.path.display()));
    }
    let verdict = match interruption::requested() {
        Some(signal) => format!("{}: {signal} at {:.2} s", Verdict::Interrupted, report.flight_s),
        None => "mirrored in shadow".to_owned(),
    };
    let state_hash = u64::from_str_radix(&report.state_hash, 16)?;
    let recording = recorder.map(|recorder| recorder.close(RecordingEnd { state_hash, verdict }));
    Ok((report, recording))
}

fn recording_info(opened: &OpenedFlight, shadow: &Shadow) -> anyhow::Result<RecordingInfo> {
    Ok(RecordingInfo {
        mirrored: true,
        per_kilogram: opened.per_kilogram(),
        scenario: format!("mirror of {}", opened.name()),
        scenario_toml: String::new(),
        seed: 0,
        gains_json: serde_json::to_string(shadow.tuning())?,
        urdf: String::new(),
        // The actuators of a recorded vehicle are unknown.
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
