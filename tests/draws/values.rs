//! Draws the value of one key: a corner of its range, zero, a value near the default, or anywhere in the range.

use rand::RngExt;
use rand_pcg::Pcg64;
use toml::Value;

use twin_core::elementary::exp;
use twin_core::quantity;

/// Small numbers are drawn over so many powers of ten below the range.
const DECADES: f64 = 12.0;

/// Rates of the inner controller, most of which divide the plant's 1000 Hz.
const INNER_HZ: [f64; 8] = [50.0, 100.0, 125.0, 200.0, 250.0, 500.0, 1000.0, 300.0];

/// A number for the key at `path`, whose default is `default`.
pub(super) fn number(rng: &mut Pcg64, path: &[String], default: f64) -> f64 {
    if path.last().is_some_and(|key| key == "inner_hz") {
        return INNER_HZ[rng.random_range(0..INNER_HZ.len())];
    }
    let Some(bounds) = quantity::at(path) else {
        // Limits of checks and bounds: any number.
        return [0.0, 1.0, -1.0, default, 1e6, -1e6][rng.random_range(0..6)];
    };
    let (min, max) = (bounds.quantity.min, bounds.quantity.max);
    let uniform = min + (max - min) * rng.random::<f64>();
    let drawn = match rng.random_range(0..8) {
        0 => min,
        1 => max,
        2 if bounds.allow(0.0) => 0.0,
        // The least number above the lower end, and a number near it on a scale of powers of ten.
        3 => min + f64::MIN_POSITIVE,
        4 if min >= 0.0 => {
            min + (max - min) * exp(-DECADES * std::f64::consts::LN_10 * rng.random::<f64>())
        }
        5 | 6 => (default * (0.5 + rng.random::<f64>())).clamp(min, max),
        _ => uniform,
    };
    if bounds.allow(drawn) { drawn } else { default.clamp(min, max) }
}

/// Words that a text without a list of allowed words may be given, wrong ones among them.
fn free_words(key: &str) -> &'static [&'static str] {
    match key {
        "vehicle.tool_link" => &["tool", "tool", "tool", "", "palm", "palm", "no_link"],
        "vehicle.gripper.joint" => &["finger_left_joint", "finger_left_joint", "", "", "joint1"],
        "vehicle.gripper.palm_link" => &["palm", "palm", "palm", "tool", ""],
        "predictor.kernel" => &["auto", "scalar", "scalar", "scalar", "scalar", "abacus"],
        "predictor.weights" => &["default", "default", "default", "default", "missing.safetensors"],
        "disturbances.name" => &twin_core::source::EFFECTS,
        "arena.objects.name" => &["box", "table", "", "a b"],
        "arena.objects.urdf" => &[
            concat!(env!("CARGO_MANIFEST_DIR"), "/urdf/box.urdf"),
            concat!(env!("CARGO_MANIFEST_DIR"), "/urdf/table.urdf"),
            concat!(env!("CARGO_MANIFEST_DIR"), "/urdf/cube.urdf"),
            concat!(env!("CARGO_MANIFEST_DIR"), "/urdf/quadrotor.urdf"),
        ],
        "checks.signal" => &["height_m", "tilt_rad", "saturated", "position_error_m"],
        "checks.phase" | "faults.when.phase" => &["hover", "approach", "transport", "nowhere"],
        "sweep.ranges.key" => &["payload.mass_kg", "seed", "title"],
        _ => &["", "x", "default"],
    }
}

/// A text for `key`, whose allowed words are `words`; empty if any text is allowed.
pub(super) fn text(rng: &mut Pcg64, key: &str, words: &[String]) -> String {
    if words.is_empty() {
        let free = free_words(key);
        return free[rng.random_range(0..free.len())].to_owned();
    }
    // A failure has a table of its own; `[[faults]]` draws failures.
    let words: Vec<&String> =
        words.iter().filter(|word| key != "disturbances.kind" || *word != "failure").collect();
    words[rng.random_range(0..words.len())].clone()
}

/// Names for a list of names.
pub(super) fn names(rng: &mut Pcg64, key: &str) -> Value {
    let lists: &[&[&str]] = match key {
        "vehicle.arm_joints" => {
            &[&["joint1", "joint2"], &["joint1"], &[], &["joint2", "joint1"], &["joint1", "joint1"]]
        }
        "changes.set" => &[
            &["gains.preset=paper"],
            &["predictor.kind=persistence", "controller.kind=pid"],
            &["wind.velocity_m_s=[2,0,0]", "aero.downwash=false"],
            &["seed=3"],
            &["="],
        ],
        _ => &[&[], &[], &["name=folder"], &["="]],
    };
    let list = lists[rng.random_range(0..lists.len())];
    Value::Array(list.iter().map(|name| Value::String((*name).to_owned())).collect())
}
