//! The network in the loop: the files that a scenario may name, those that are refused, and the flights, recordings and views.

use std::path::PathBuf;

use twin_core::notation::{COORDINATE_NAMES, Coords};
use twin_core::residual::nn::Precision;
use twin_core::residual::nn::kernels::Kernel;
use twin_core::residual::weights::{Acceptance, FdtConfig, SHIPPED, Weights, channel_names};
use twin_core::residual::{Fdt, History, Predictor};
use twin_core::tick::Tick;
use twin_record::{Recorder, RecordingEnd, read_recording};
use twin_scenario::{Scenario, acceptance, fly};

use super::made;

/// Weights that forecast a constant: all are zero except for the mean of the residual, which carries a hovering vehicle.
fn carrying(m_bar: &[f64]) -> Weights {
    let mut weights = made::weights(&FdtConfig::SMALL, 9);
    for name in
        ["decoder.readout.out.weight", "decoder.readout.out.bias", "skip.weight", "skip.bias"]
    {
        weights.tensors.get_mut(name).expect(name).values.fill(0.0);
    }
    weights.head.m_bar = m_bar.to_vec();
    weights.head.normalisation.output_mean = vec![0.0; 8];
    // Weight of the vehicle without payload, N; the adapter and the robust term correct the rest.
    weights.head.normalisation.output_mean[2] = 29.4;
    weights.head.acceptance = Acceptance { r2: Some(0.85), ..Acceptance::default() };
    weights
}

fn m_bar() -> Vec<f64> {
    let tuning = scenario("hover", &[]).tuning().expect("gains");
    tuning.gains.nominal_inertia.iter().copied().collect()
}

fn scenario(name: &str, overrides: &[String]) -> Scenario {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("scenarios/{name}.toml"));
    Scenario::load(&file, overrides).expect("it is usable")
}

/// A scenario that flies `weights`, which are written to a file called `name`.
fn with(name: &str, weights: &Weights, more: &[&str]) -> Scenario {
    let path = file(name, weights);
    let mut overrides = vec![
        "predictor.kind=fdt".to_owned(),
        format!("predictor.weights={:?}", path.display().to_string()),
        "task.duration_s=4.0".to_owned(),
    ];
    overrides.extend(more.iter().map(|text| (*text).to_owned()));
    scenario("hover", &overrides)
}

fn file(name: &str, weights: &Weights) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("fdt_flying");
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(name);
    std::fs::write(&path, weights.to_bytes().expect("weights")).expect("it is written");
    path
}

fn refusal(scenario: &Scenario) -> String {
    scenario.build().err().expect("it is refused").to_string()
}

#[test]
fn the_history_is_z_scored_masked_and_held_at_its_start() {
    let weights = made::weights(&FdtConfig::SMALL, 3);
    let mut fdt = Fdt::new(&weights, Kernel::SCALAR, Precision::F32).expect("weights");
    let entry = |v: f64| Coords::from_fn(|row, _| v + row as f64);
    let filled = |first: f64, ticks: usize, x: f64| {
        let mut history = History::new(120);
        for tick in 0..ticks {
            let mut chi = entry(if tick == 0 { first } else { 1.0 });
            chi[0] = x;
            history.push(chi, entry(0.5), entry(2.0), entry(3.0));
        }
        history
    };
    let short = fdt.predict(&filled(1.0, 1, 0.0));
    assert_eq!(
        short,
        fdt.predict(&filled(1.0, 120, 0.0)),
        "a single entry is repeated, so it equals a long rest"
    );
    assert_eq!(short, fdt.predict(&filled(1.0, 120, 77.0)), "x is masked");
    assert_ne!(short, fdt.predict(&filled(1.5, 120, 0.0)), "the oldest entry counts");
    assert_eq!((short.base.len(), short.regime.len()), (26, 32));
    assert!((short.attention.iter().sum::<f64>() - 1.0).abs() < 1e-5, "shares of one");
}

#[test]
fn weights_fly_with_the_adapter_and_their_attention_is_recorded_and_replayed() {
    let scenario = with("carrying.safetensors", &carrying(&m_bar()), &["predictor.kernel=scalar"]);
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("fdt_flying/flight.mcap");
    // A recording of an earlier run is of no use; the recorder makes a new file only.
    let _ = std::fs::remove_file(&path);
    let info = scenario.recording_info(&scenario.tuning().expect("gains")).expect("info");
    let mut recorder = Recorder::create(&path, &info).expect("a recorder");
    let mut ticks: Vec<Tick> = Vec::new();
    let report = fly(&scenario, &mut |tick| {
        recorder.record(std::sync::Arc::new(tick.clone())).expect("recorded");
        ticks.push(tick.clone());
    })
    .expect("it flies");
    recorder.finish(RecordingEnd::default()).expect("written");
    assert!(report.passed, "{}", report.reason);
    assert_eq!(report.kernel, "scalar");
    let again = fly(&scenario, &mut |_| {}).expect("it flies");
    assert_eq!(again.state_hash, report.state_hash, "the same weights fly the same flight");

    let recording = read_recording(&path).expect("it opens");
    assert_eq!(recording.metadata["kernel"], "scalar");
    assert!(recording.metadata["predictor"].contains("tau.q2"), "the channels are named");
    assert_eq!(recording.ticks[100].forecast, ticks[100].forecast);
    assert_eq!(ticks[100].forecast.attention.len(), channel_names().len());
}

#[test]
fn the_weights_it_ships_are_accepted_and_fly_the_default_mission() {
    let shipped = Weights::from_bytes(SHIPPED).expect("they are whole");
    assert!(shipped.head.acceptance.passed(), "{}", shipped.head.acceptance);
    // They are of the architecture without the linear path.
    assert_eq!(FdtConfig::of(&shipped.head).expect("a configuration"), FdtConfig::SMALL);
    assert!(SHIPPED.len() <= 1_000_000, "{} bytes", SHIPPED.len());
    let default = scenario("a_300g_slow", &[]);
    let tick = default.build().expect("it is accepted").tick();
    assert_eq!(tick.forecast.attention.len(), channel_names().len());
}

#[test]
fn the_gate_measures_shipped_weights_as_their_head_says() {
    let path = file("shipped.safetensors", &Weights::from_bytes(SHIPPED).expect("whole"));
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let flown: Vec<_> = ["hover", "gate_figure_eight"]
        .iter()
        .map(|name| {
            let scenario = root.join(format!("scenarios/{name}.toml"));
            let kernel = ["predictor.kernel=scalar".to_owned()];
            acceptance::fly(&scenario, &path, &kernel).expect("flown")
        })
        .collect();
    let (r2, _) = acceptance::together(&flown).expect("both are completed");
    let said = Weights::from_bytes(SHIPPED).expect("whole").head.acceptance.r2.expect("a figure");
    // Another kernel rounds differently, so the flight does not repeat bit for bit.
    assert!(r2 > Acceptance::LEAST_R2 && (r2 - said).abs() < 0.02, "{r2} and {said}");
}

#[test]
fn only_accepted_weights_fly_unless_forced() {
    let mut weights = carrying(&m_bar());
    weights.head.acceptance = Acceptance { r2: None, hover_r2: Some(0.9), figure_eight_r2: None };
    let name = "unaccepted.safetensors";
    let words = refusal(&with(name, &weights, &[]));
    for part in ["R² not flown", "hover alone 0.900", "figure-8 alone not flown", "--force-weights"]
    {
        assert!(words.contains(part), "{part:?} is not in {words:?}");
    }
    weights.head.acceptance.r2 = Some(0.8);
    assert!(refusal(&with(name, &weights, &[])).contains("R² 0.800"), "0.8 is not above");
    assert!(with(name, &weights, &["predictor.force=true"]).build().is_ok());
}

#[test]
fn weights_of_another_flight_are_refused_in_words() {
    let good = carrying(&m_bar());
    let mut heavy = good.clone();
    heavy.head.m_bar[2] *= 1.5;
    assert!(refusal(&with("heavy.safetensors", &heavy, &[])).contains("M̄ z"), "another inertia");
    let slow = refusal(&with("slow.safetensors", &good, &["controller.outer_divisor=2"]));
    assert!(slow.contains("100 Hz") && slow.contains("50 Hz"), "{slow}");
    let kernel = refusal(&with("k.safetensors", &good, &["predictor.kernel=abacus"]));
    assert!(kernel.contains("abacus") && kernel.contains("scalar"), "{kernel}");
    let missing = refusal(&scenario(
        "hover",
        &["predictor.kind=fdt", "predictor.weights=nowhere.safetensors"].map(str::to_owned),
    ));
    assert!(missing.contains("nowhere.safetensors") && missing.contains("twin train"), "{missing}");
    let path = file("carried.safetensors", &good);
    let quadrotor = refusal(&scenario(
        "quadrotor",
        &[
            "predictor.kind=fdt".to_owned(),
            format!("predictor.weights={:?}", path.display().to_string()),
        ],
    ));
    assert!(quadrotor.contains("chi.q1") && quadrotor.contains("0 joints"), "{quadrotor}");
}

#[test]
fn acceptance_flies_the_base_forecast_alone_and_writes_the_head() {
    let path = file("judged.safetensors", &carrying(&m_bar()));
    let hover = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenarios/hover.toml");
    let flown = acceptance::fly(&hover, &path, &["task.duration_s=4.0".to_owned()]).expect("flown");
    // A constant cannot explain the variation of the residual.
    assert!(flown.r2 < 0.1, "{flown:?}");
    assert_eq!(flown.r2_rows.len(), COORDINATE_NAMES.len());
    let figures = Acceptance { r2: Some(0.5), hover_r2: Some(0.25), figure_eight_r2: None };
    acceptance::write(&path, figures).expect("written");
    let read = Weights::from_bytes(&std::fs::read(&path).expect("a file")).expect("weights");
    assert_eq!(read.head.acceptance, figures);
    assert_eq!(read.tensors, carrying(&m_bar()).tensors, "nothing else has changed");
}
