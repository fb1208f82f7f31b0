//! Time of one forecast of the Factorized Dynamics Transformer on one core, with random weights.
//!
//! `cargo bench --bench inference` prints a table. `-- --write DIR` writes the weights and histories that the table uses, and
//! `-- --serve FILE ARITHMETIC` answers `tests/bench/inference_export.py`, which times this program and other runtimes in turn.
#![allow(clippy::disallowed_methods, reason = "a benchmark asks the clock")]
#![allow(clippy::print_stdout, reason = "its result is the table")]

use std::hint::black_box;
use std::io::BufRead;
use std::path::Path;
use std::time::Instant;

use twin_core::elementary::sin;
use twin_core::notation::Coords;
use twin_core::residual::fdt::{Fast, Model};
use twin_core::residual::lra::{Adapter, Settings};
use twin_core::residual::nn::Precision;
use twin_core::residual::nn::kernels::Kernel;
use twin_core::residual::weights::{FdtConfig, Weights};
use twin_core::residual::{Fdt, History, Predictor};

#[allow(dead_code, reason = "the tests use more of it")]
#[path = "../fdt/made.rs"]
mod made;

const SIZES: [(&str, FdtConfig); 2] = [("small", FdtConfig::SMALL), ("paper", FdtConfig::PAPER)];

/// Seed of weights and history.
const SEED: u64 = 1;

/// Calls that warm the caches up, and calls that are timed.
const WARM_UP: usize = 50;
const CALLS: usize = 400;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["--write", folder] => write(Path::new(folder)),
        ["--serve", file, arithmetic] => serve(Path::new(file), arithmetic),
        _ => table(),
    }
}

/// Every arithmetic of this processor by its name.
fn arithmetics() -> Vec<(String, Kernel, Precision)> {
    Kernel::available()
        .into_iter()
        .flat_map(|kernel| [Precision::F32, Precision::Bf16].map(|precision| (kernel, precision)))
        .map(|(kernel, precision)| {
            let bf16 = if precision == Precision::Bf16 { "_bf16" } else { "" };
            (format!("{}{bf16}", kernel.name()), kernel, precision)
        })
        .collect()
}

fn table() {
    println!("{:6} {:24} {:>9} {:>9} {:>9}", "size", "what", "min ms", "p50 ms", "p99 ms");
    for (size, config) in SIZES {
        let weights = made::weights(&config, SEED);
        let model = Model::new(&weights).expect("weights");
        let x = made::history(&config, SEED);
        let calls = if size == "paper" { CALLS / 20 } else { CALLS };
        print(size, "plain, as the equations", &time(calls, || drop(black_box(model.forward(&x)))));
        for (name, kernel, precision) in arithmetics() {
            let mut fast = Fast::new(&model, kernel, precision);
            print(size, &name, &time(CALLS, || drop(black_box(fast.forward(&x)))));
            let mut both = Both::new(&weights, kernel, precision);
            print(size, &format!("{name} + window + LRA"), &time(CALLS, || both.step()));
        }
    }
}

/// Milliseconds of each call, sorted.
fn time(calls: usize, mut call: impl FnMut()) -> Vec<f64> {
    (0..WARM_UP.min(calls)).for_each(|_| call());
    let mut times: Vec<f64> = (0..calls).map(|_| timed(&mut call)).collect();
    times.sort_by(f64::total_cmp);
    times
}

fn timed(call: &mut impl FnMut()) -> f64 {
    let start = Instant::now();
    call();
    start.elapsed().as_secs_f64() * 1e3
}

fn print(size: &str, what: &str, sorted: &[f64]) {
    let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
    println!("{size:6} {what:24} {:9.4} {:9.4} {:9.4}", at(0.0), at(0.5), at(0.99));
}

/// Forecast from a history followed by the adaptation, as in a tick.
struct Both {
    fdt: Fdt,
    adapter: Adapter,
    history: History,
    settings: Settings,
}

impl Both {
    fn new(weights: &Weights, kernel: Kernel, precision: Precision) -> Self {
        let fdt = Fdt::new(weights, kernel, precision).expect("weights of the vehicle");
        let mut history = History::new(fdt.history_len());
        for tick in 0..fdt.history_len() {
            let wave = Coords::from_fn(|row, _| sin(0.1 * tick as f64 + row as f64));
            history.push(wave, wave, wave, wave);
        }
        let settings = Settings::default();
        let adapter = Adapter::new(fdt.regime_len(), fdt.info().scale, &settings);
        Self { fdt, adapter, history, settings }
    }

    fn step(&mut self) {
        let forecast = self.fdt.predict(&self.history);
        let residual = Coords::repeat(0.5).into();
        black_box(self.adapter.step(
            &forecast,
            &self.history,
            &residual,
            0.01,
            false,
            &self.settings,
        ));
    }
}

fn write(folder: &Path) {
    std::fs::create_dir_all(folder).expect("a folder");
    for (size, config) in SIZES {
        let bytes = made::weights(&config, SEED).to_bytes().expect("weights");
        std::fs::write(folder.join(format!("{size}.safetensors")), bytes).expect("written");
        let x = made::history(&config, SEED);
        let bytes: Vec<u8> = x.iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(folder.join(format!("{size}.input")), bytes).expect("written");
    }
}

/// Answers each line of stdin as JSON: `run N` with the times of N calls in ms, `forward` with the residual and the regime.
fn serve(file: &Path, arithmetic: &str) {
    let weights = Weights::from_bytes(&std::fs::read(file).expect("a file")).expect("weights");
    let model = Model::new(&weights).expect("weights");
    let bytes = std::fs::read(file.with_extension("input")).expect("a history");
    let x: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let (_, kernel, precision) = arithmetics()
        .into_iter()
        .find(|(name, ..)| {
            name == arithmetic || arithmetic == "best" && *name == Kernel::best().name()
        })
        .expect("an arithmetic of this processor");
    let mut fast = Fast::new(&model, kernel, precision);
    for line in std::io::stdin().lock().lines() {
        let line = line.expect("text");
        let answer = if let Some(calls) = line.strip_prefix("run ") {
            let calls: usize = calls.trim().parse().expect("a number");
            let mut call = || drop(black_box(fast.forward(&x)));
            serde_json::json!((0..calls).map(|_| timed(&mut call)).collect::<Vec<_>>())
        } else {
            let output = fast.forward(&x);
            serde_json::json!({ "residual": output.residual, "regime": output.regime })
        };
        println!("{answer}");
    }
}
