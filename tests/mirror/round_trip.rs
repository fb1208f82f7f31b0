//! A recording of a simulated flight, mirrored: the residuals are equal bit for bit, because no value is resampled.

use std::sync::Arc;

use twin_core::tick::Tick;
use twin_foreign::shadow;
use twin_foreign::{Effort, OpenedFlight};
use twin_record::{Recorder, RecordingEnd};
use twin_scenario::{Scenario, fly};

use super::made::file;

fn hover() -> Scenario {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/hover.toml");
    Scenario::load(&path, &["task.duration_s=3".to_owned()]).expect("a scenario")
}

/// Flies and records; returns the ticks of the flight.
pub(crate) fn record(path: &std::path::Path) -> Vec<Tick> {
    let scenario = hover();
    let tuning = scenario.tuning().expect("gains");
    let info = scenario.recording_info(&tuning).expect("a model");
    // The recorder makes a new file only; whether there is an old one does not matter.
    let _ = std::fs::remove_file(path);
    let mut recorder = Recorder::create(path, &info).expect("a file");
    let mut ticks = Vec::new();
    fly(&scenario, &mut |tick| {
        recorder.record(Arc::new(tick.clone())).expect("room on the disk");
        ticks.push(tick.clone());
    })
    .expect("a flight");
    recorder.finish(RecordingEnd::default()).expect("written");
    ticks
}

#[test]
fn a_recorded_simulation_is_mirrored_with_its_residuals_bit_for_bit() {
    let path = file("round_trip.mcap", b"");
    let flown = record(&path);
    let opened = OpenedFlight::open(&path, None).expect("readable");
    assert_eq!(opened.recorded.effort, Effort::Recorded);
    let mut mirrored = Vec::new();
    shadow(&opened.recorded, None, &mut |tick| mirrored.push(tick.clone())).expect("ticks");
    assert_eq!((mirrored.len(), flown.len() > 250), (flown.len(), true));
    for (one, other) in flown.iter().zip(&mirrored) {
        let bits = |tick: &Tick| {
            let m = &tick.measurement;
            let all = [&m.chi, &m.chi_dot, &m.chi_ddot, &m.tau_applied, &tick.residual];
            all.map(|values| values.map(f64::to_bits))
        };
        assert_eq!(bits(one), bits(other), "tick {}", one.index);
        assert_eq!(one.measurement.t_s.to_bits(), other.measurement.t_s.to_bits());
    }
}
