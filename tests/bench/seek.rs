//! Times of start and seek of flights of an hour, and their memory.
//!
//! `cargo bench --bench seek`. The files are a made flight of another program and a recording of this program, each of a quarter of
//! an hour and of an hour. If `TWIN_FLIGHTS` names the folder of real flights, the PX4 flight `waypoint4`, repeated for an hour, is a
//! fifth. A process of its own serves each file, and a console watches it. The start is the time from opening the file to the first
//! tick. A seek is the time from the request to the tick that was sought, with the 10 s before it.
#![allow(
    missing_docs,
    dead_code,
    unused_imports,
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a bench measures wall-clock time, and uses a part of the tests' helpers"
)]

#[path = "../server/console.rs"]
mod console;
#[path = "../patience.rs"]
mod patience;
#[path = "../folder.rs"]
#[expect(dead_code, reason = "the suite uses the rest")]
mod folder;
#[path = "../mirror/made.rs"]
mod made;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use console::{Arrival, Console};
use mcap::records::MessageHeader;
use rand::{RngExt, SeedableRng};
use twin_console::server::{Limits, MirrorOptions, spawn_mirror};
use twin_core::notation::TICK_S;
use twin_core::tick::Tick;
use twin_foreign::OpenedFlight;
use twin_record::{Recorder, RecordingEnd};
use twin_scenario::Scenario;

/// Environment variable that names the file in the process that serves it.
const FILE: &str = "TWIN_SEEK_FILE";

/// Number of seeks in each file.
const SEEKS: usize = 200;

const HOUR_S: f64 = 3600.0;

fn main() {
    match std::env::var_os(FILE) {
        Some(file) => measure(Path::new(&file)),
        None => all(),
    }
}

fn all() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/long-flights");
    std::fs::create_dir_all(&folder).unwrap();
    let mut files = Vec::new();
    for (word, seconds) in [("quarter", HOUR_S / 4.0), ("hour", HOUR_S)] {
        files.push(made_once(&folder, &format!("made_{word}.mcap"), &|path| {
            std::fs::write(
                path,
                made::flight(made::Form { seconds, chunk_bytes: 1 << 19, ..made::PLAIN }),
            )
            .unwrap();
        }));
        files.push(made_once(&folder, &format!("own_{word}.mcap"), &|path| own(path, seconds)));
    }
    if let Some(flights) = std::env::var_os("TWIN_FLIGHTS") {
        let from = Path::new(&flights).join("px4_arm/20250612_waypoint4_px4.mcap");
        files.push(made_once(&folder, "waypoint4_hour.mcap", &|path| repeated(&from, path)));
    }
    println!("| file | MB | start ms | seek p50 ms | p99 ms | longest ms | peak memory MiB |");
    println!("|---|---|---|---|---|---|---|");
    for file in files {
        let program = std::env::current_exe().unwrap();
        assert!(Command::new(program).env(FILE, &file).status().unwrap().success());
    }
}

fn made_once(folder: &Path, name: &str, make: &dyn Fn(&Path)) -> PathBuf {
    let path = folder.join(name);
    if !path.exists() {
        let part = folder.join("part");
        make(&part);
        std::fs::rename(&part, &path).unwrap();
    }
    path
}

/// A recording of this program: 20 s of flight, repeated with continued time.
fn own(path: &Path, seconds: f64) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/a_300g_slow.toml");
    let scenario = Scenario::load(&file, &[]).unwrap();
    let mut flight = scenario.build().unwrap();
    let flown: Vec<Tick> = (0..2000).map(|_| flight.tick()).collect();
    let info = scenario.recording_info(flight.tuning()).unwrap();
    let mut recorder = Recorder::create(path, &info).unwrap();
    for index in 0..(seconds / TICK_S) as u64 {
        let mut tick = flown[index as usize % flown.len()].clone();
        tick.index = index;
        tick.measurement.t_s = index as f64 * TICK_S;
        recorder.record(Arc::new(tick)).unwrap();
    }
    recorder.finish(RecordingEnd::default()).unwrap();
}

/// A PX4 flight that is repeated, each time later; the time stamps inside its messages are shifted too.
fn repeated(from: &Path, to: &Path) {
    let bytes = std::fs::read(from).unwrap();
    let messages: Vec<mcap::Message> =
        mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
    let first = messages.iter().map(|message| message.log_time).min().unwrap();
    let last = messages.iter().map(|message| message.log_time).max().unwrap();
    let mut writer = mcap::WriteOptions::new()
        .profile("ros2")
        .create(std::io::BufWriter::new(std::fs::File::create(to).unwrap()))
        .unwrap();
    let period_ns = last - first + 10_000_000;
    for shift_ns in (0..).map(|k| k * period_ns).take_while(|shift| (*shift as f64) < HOUR_S * 1e9)
    {
        for message in &messages {
            let mut message = message.clone();
            let text = message.channel.schema.as_ref().map_or(&[][..], |schema| &schema.data);
            let text = String::from_utf8_lossy(text).into_owned();
            let own = text.split("====").next().unwrap_or_default();
            let data = message.data.to_mut();
            // A message of PX4 begins with its time in microseconds. Many continue with the time of its sample.
            let stamps = 1 + usize::from(own.contains("timestamp_sample"));
            for at in (0..stamps).map(|stamp| 4 + 8 * stamp) {
                let Some(place) = data.get_mut(at..at + 8) else { continue };
                let stamp = u64::from_le_bytes((&*place).try_into().unwrap());
                place.copy_from_slice(&(stamp + shift_ns / 1000).to_le_bytes());
            }
            message.log_time += shift_ns;
            message.publish_time += shift_ns;
            writer.write(&message).unwrap();
        }
    }
    writer.finish().unwrap();
}

/// Serves the file and watches it.
fn measure(file: &Path) {
    let start = Instant::now();
    let opened = OpenedFlight::open(file, None).unwrap();
    let opened_in = start.elapsed();
    let seconds = opened.long.as_ref().unwrap().ticks() as f64 * TICK_S;
    let running = spawn_mirror(MirrorOptions {
        opened,
        forecaster: twin_foreign::Forecaster::default(),
        live: None,
        host: "127.0.0.1".to_owned(),
        port: 0,
        speed: Some(1.0),
        start_s: 0.0,
        start_paused: false,
        viewer_dir: None,
        foxglove_port: None,
        foxglove_origins: Vec::new(),
        limits: Limits::STANDARD,
    })
    .unwrap();
    let mut console = Console::connect(running.address());
    console.frame();
    let started = start.elapsed();
    let mut rng = rand_pcg::Pcg64::seed_from_u64(8);
    let mut times: Vec<Duration> =
        (0..SEEKS).map(|_| seek(&mut console, rng.random_range(11.0..seconds - 1.0))).collect();
    times.sort();
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    println!(
        "| {} | {:.0} | {:.0} (open {:.0}) | {:.0} | {:.0} | {:.0} | {:.0} |",
        file.file_name().unwrap().to_string_lossy(),
        std::fs::metadata(file).unwrap().len() as f64 / 1e6,
        ms(started),
        ms(opened_in),
        ms(times[SEEKS / 2]),
        ms(times[SEEKS * 99 / 100 - 1]),
        ms(times[SEEKS - 1]),
        peak_memory_mib(),
    );
}

/// Time until the console has the tick at `t_s`.
fn seek(console: &mut Console, t_s: f64) -> Duration {
    let target = (t_s / TICK_S).round() as u64;
    let start = Instant::now();
    console.send(&format!(r#"{{"type":"seek","t_s":{t_s}}}"#));
    let hello = console.message("hello");
    let schema = hello["schema_id"].as_u64().unwrap();
    loop {
        if let Arrival::Frame(frame) = console.next()
            && u64::from(frame.schema_id) == schema
            && frame.after() > target
        {
            return start.elapsed();
        }
    }
}

/// Largest memory that this process has held, MiB.
fn peak_memory_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM")).unwrap_or_default();
    line.split_whitespace().nth(1).and_then(|kb| kb.parse::<f64>().ok()).unwrap_or(f64::NAN)
        / 1024.0
}
