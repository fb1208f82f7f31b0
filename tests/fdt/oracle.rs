//! The forward pass compared with that of `NumPy` in double precision, which reads the same files and shares no code.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;
use twin_core::residual::fdt::{Model, Output};
use twin_core::residual::weights::FdtConfig;

use super::made;

/// Largest difference, relative to the largest number of the output: single precision through a dozen sums.
const TOLERANCE: f64 = 1e-5;

/// Output of the script for a case.
#[derive(Deserialize)]
struct Wanted {
    residual: Vec<f64>,
    regime: Vec<f64>,
    attention: Vec<f64>,
}

#[test]
fn the_forward_pass_is_numpys_for_every_ablation_and_odd_sizes() {
    let Some(python) = python() else {
        eprintln!("SKIPPED: no Python with NumPy; tests/run installs one into target/venv");
        return;
    };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fdt_oracle");
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut configs = made::ablations(FdtConfig::SMALL);
    configs.extend((1..=8).flat_map(|seed| made::ablations(made::odd(seed))));
    for (case, config) in configs.iter().enumerate() {
        let seed = case as u64;
        let write = |ending: &str, bytes: &[u8]| {
            std::fs::write(folder.join(format!("{case}.{ending}")), bytes).expect("it is written");
        };
        write("safetensors", &made::weights(config, seed).to_bytes().expect("weights"));
        let bytes: Vec<u8> =
            made::history(config, seed).iter().flat_map(|v| v.to_le_bytes()).collect();
        write("input", &bytes);
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fdt/oracle.py");
    let status = Command::new(python)
        .arg(script)
        .arg(&folder)
        .arg(configs.len().to_string())
        .status()
        .expect("Python runs");
    assert!(status.success());
    for (case, config) in configs.iter().enumerate() {
        let seed = case as u64;
        let text = std::fs::read_to_string(folder.join(format!("{case}.json"))).expect("an answer");
        let wanted: Wanted = serde_json::from_str(&text).expect("as agreed");
        let model = Model::new(&made::weights(config, seed)).expect("weights");
        agrees(config, &model.forward(&made::history(config, seed)), &wanted);
    }
}

fn agrees(config: &FdtConfig, found: &Output, wanted: &Wanted) {
    for (what, found, wanted) in [
        ("residual", &found.residual, &wanted.residual),
        ("regime", &found.regime, &wanted.regime),
        ("attention", &found.attention, &wanted.attention),
    ] {
        assert_eq!(found.len(), wanted.len(), "{what} of {config:?}");
        let largest = wanted.iter().fold(1e-3, |most, v| v.abs().max(most));
        for (index, (found, wanted)) in found.iter().zip(wanted).enumerate() {
            let difference = (f64::from(*found) - wanted).abs() / largest;
            assert!(
                difference < TOLERANCE,
                "{what}[{index}] is {found}, NumPy has {wanted}, of {config:?}"
            );
        }
    }
}

/// A Python with `NumPy`: that of the suite, or else that of the system.
fn python() -> Option<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/venv/bin/python");
    [own, PathBuf::from("python3")].into_iter().find(|python| {
        Command::new(python)
            .args(["-c", "import numpy"])
            .stderr(std::process::Stdio::null())
            .status()
            .is_ok_and(|status| status.success())
    })
}
