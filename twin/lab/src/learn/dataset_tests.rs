//! Recordings as series, compared with the ticks that were recorded.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Dataset, LearnError};
use twin_core::tick::{Adaptation, Fault, Tick};
use twin_record::{Recorder, RecordingEnd, RecordingInfo, fixture};

const TICKS: u64 = 250;

fn record(path: &Path, ticks: &[Tick], inertia: f64) {
    let m_bar = vec![inertia.to_string(); 8].join(",");
    let info = RecordingInfo {
        mirrored: false,
        per_kilogram: false,
        scenario: "unit".to_owned(),
        scenario_toml: String::new(),
        seed: 7,
        gains_json: format!("{{\"gains\":{{\"nominal_inertia\":[{m_bar}]}}}}"),
        limits_json: "{}".to_owned(),
        predictor_json: "{}".to_owned(),
        kernel: "scalar".to_owned(),
        urdf: "<robot name=\"r\"/>".to_owned(),
        scene: fixture::scene(),
        joint_names: vec!["joint1".to_owned(), "joint2".to_owned()],
    };
    let mut recorder = Recorder::create(path, &info).unwrap();
    for tick in ticks {
        recorder.record(Arc::new(tick.clone())).unwrap();
    }
    recorder.finish(RecordingEnd::default()).unwrap();
}

fn ticks() -> Vec<Tick> {
    let mut ticks: Vec<Tick> = (0..TICKS).map(fixture::tick).collect();
    for tick in &mut ticks {
        tick.reference.adaptation = Adaptation::Free;
        tick.reference.follows_measurement = false;
        tick.fault = None;
    }
    ticks
}

#[test]
fn series_are_what_was_recorded_and_the_force_is_of_the_tick_before() {
    let folder = tempfile::tempdir().unwrap();
    let (path, mut ticks) = (folder.path().join("flight.mcap"), ticks());
    ticks[20].reference.adaptation = Adaptation::Held;
    ticks[30].reference.follows_measurement = true;
    ticks[40].fault = Some(Fault::NonFiniteMeasurement);
    record(&path, &ticks, 2.0);
    let data = Dataset::read(std::slice::from_ref(&path)).unwrap();
    assert_eq!(data.channel_names.len(), 24);
    assert_eq!(
        (data.channel_names[2].as_str(), data.channel_names[18].as_str()),
        ("chi.z", "tau.z")
    );
    assert_eq!((data.nominal_inertia.clone(), data.left_out.len()), (vec![2.0; 8], 0));
    let flight = &data.flights[0];
    for t in 1..ticks.len() {
        let (now, before) = (&ticks[t], &ticks[t - 1]);
        assert_eq!(flight.inputs[2][t].to_bits(), (now.measurement.chi[2] as f32).to_bits());
        assert_eq!(flight.inputs[8][t].to_bits(), (now.measurement.chi_dot[0] as f32).to_bits());
        assert_eq!(
            flight.inputs[18][t].to_bits(),
            (before.measurement.tau_applied[2] as f32).to_bits()
        );
        assert_eq!(flight.outputs[7][t].to_bits(), (now.residual[7] as f32).to_bits());
    }
    let left: Vec<usize> = (0..ticks.len()).filter(|t| !flight.usable[*t]).collect();
    assert_eq!(left, [20, 30, 40], "frozen, following and faulty ticks are not learned from");
}

#[test]
fn equal_data_has_an_equal_hash_whatever_the_file_is_called() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, c] = ["a.mcap", "b.mcap", "c.mcap"].map(|name| folder.path().join(name));
    let mut other = ticks();
    other[100].measurement.chi[0] += 1e-3;
    record(&a, &ticks(), 2.0);
    record(&b, &ticks(), 2.0);
    record(&c, &other, 2.0);
    let hash = |path: &PathBuf| Dataset::read(std::slice::from_ref(path)).unwrap().hash();
    assert_eq!((hash(&a), hash(&a).len()), (hash(&b), 64));
    assert_ne!(hash(&a), hash(&c));
}

#[test]
fn data_that_cannot_be_learned_from_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let names = ["whole.mcap", "cut.mcap", "heavy.mcap", "nan.mcap"];
    let [whole, cut, heavy, nan] = names.map(|name| folder.path().join(name));
    record(&whole, &ticks(), 2.0);
    record(&heavy, &ticks(), 3.0);
    let mut broken = ticks();
    broken[17].measurement.chi_dot[1] = f64::NAN;
    record(&nan, &broken, 2.0);
    let bytes = std::fs::read(&whole).unwrap();
    std::fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let read = |paths: &[&PathBuf]| {
        let paths: Vec<PathBuf> = paths.iter().map(|path| (*path).clone()).collect();
        Dataset::read(&paths).unwrap_err().to_string()
    };
    let error = read(&[&cut]);
    assert!(error.contains("cut.mcap") && error.contains("record the flight again"), "{error}");
    let error = read(&[&whole, &heavy]);
    assert!(error.contains("heavy.mcap") && error.contains("M_bar"), "{error}");
    let error = read(&[&nan]);
    assert!(error.contains("chi_dot.y is NaN at tick 17"), "{error}");
    let error = read(&[&folder.path().join("absent.mcap")]);
    assert!(error.contains("absent.mcap"), "{error}");
    assert!(matches!(Dataset::read(&[]), Err(LearnError::NoData)));
}
