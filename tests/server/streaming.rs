//! One twin mirrors another through Foxglove's protocol. It shows the flight of the other, reports the loss of the stream, shows unknown
//! values meanwhile, and resumes without a command.

use serde_json::Value;

use super::console::{Arrival, Console, options};
use crate::patience::{PATIENCE, Patience};
use twin_console::server::{Limits, MirrorOptions, Running, ServeOptions, spawn, spawn_mirror};
use twin_foreign::live::{From, Live};

fn source(port: u16) -> Running {
    spawn(ServeOptions { foxglove_port: Some(port), ..options() }).expect("a free port")
}

/// The newest telemetry row of a mirror, by channel.
struct Watch {
    console: Console,
    hello: Value,
}

impl Watch {
    fn new(running: &Running) -> Self {
        let mut console = Console::connect(running.address());
        let hello = console.message("hello");
        Self { console, hello }
    }

    /// Waits until `fits` is true for a channel in the newest row; returns the notices before.
    fn until(&mut self, name: &str, fits: impl Fn(f32) -> bool) -> Vec<String> {
        let patience = Patience::new();
        let mut notices = Vec::new();
        let mut last = f32::NAN;
        while patience.lasts() {
            match self.console.next() {
                Arrival::Json(said) if said["type"] == "hello" => self.hello = said,
                Arrival::Json(said) if said["type"] == "notice" => {
                    notices.push(said["text"].to_string());
                }
                Arrival::Json(_) => {}
                Arrival::Frame(frame) => {
                    let schema = self.hello["schema_id"].as_u64();
                    let channels = self.hello["channels"].as_array().expect("a list");
                    let place = channels.iter().position(|channel| channel["name"] == name);
                    let row =
                        frame.rows.last().filter(|_| Some(u64::from(frame.schema_id)) == schema);
                    if let (Some(place), Some(row)) = (place, row) {
                        last = row[place];
                        if fits(last) {
                            return notices;
                        }
                    }
                }
                Arrival::Closed(why) => panic!("closed: {why:?}"),
            }
        }
        panic!("{name} is {last}; notices: {notices:?}");
    }
}

#[test]
fn a_twin_mirrors_another_and_goes_on_after_the_stream_was_lost() {
    let other = source(0);
    let port = other.foxglove_address().expect("it serves Foxglove").port();
    let live =
        Live::listen(&From::Socket(format!("ws://127.0.0.1:{port}")), None).expect("a thread");
    let opened = live.wait(PATIENCE).expect("a flight");
    let running = spawn_mirror(MirrorOptions {
        opened,
        forecaster: twin_foreign::Forecaster::default(),
        live: Some(live),
        host: "127.0.0.1".to_owned(),
        port: 0,
        speed: Some(1.0),
        start_s: f64::MAX,
        start_paused: false,
        viewer_dir: None,
        foxglove_port: None,
        foxglove_origins: Vec::new(),
        limits: Limits::STANDARD,
    })
    .expect("a free port");
    let mut watch = Watch::new(&running);
    assert_eq!(watch.hello["mirror"]["live"], true);
    // It hovers well above the ground, at less than the height of a room.
    watch.until("chi.z", |z| (0.5..3.0).contains(&z));
    other.stop();
    watch.until("chi.z", f32::is_nan);
    watch.console.message_that("state", |state| state["task_phase"] == "stream lost");
    let again = source(port);
    watch.until("chi.z", |z| (0.5..3.0).contains(&z));
    again.stop();
}
