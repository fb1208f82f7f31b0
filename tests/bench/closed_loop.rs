//! Real-time factor of the closed loop on one core, and the shares of the stages in the time of a tick.
//!
//! `cargo bench --bench closed_loop`. The plant sets the least time of a tick: ten steps of 1 ms.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a bench measures wall-clock time"
)]

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use twin_core::flight::Flight;
use twin_core::notation::TICK_S;
use twin_scenario::Scenario;

/// Ticks over which the shares are averaged.
const SHARE_TICKS: usize = 1000;

fn flight(name: &str, overrides: &[&str]) -> Flight {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    Scenario::load(Path::new(name), &overrides).unwrap().build().unwrap()
}

/// Prints the real-time factor and the share of each stage.
fn shares(label: &str, flight: &mut Flight) {
    let mut spent: BTreeMap<String, Duration> = BTreeMap::new();
    let started = Instant::now();
    for _ in 0..SHARE_TICKS {
        let mut last = Instant::now();
        flight.tick_with(&mut |stage| {
            let now = Instant::now();
            *spent.entry(format!("{stage:?}")).or_default() += now - last;
            last = now;
        });
    }
    let total = started.elapsed();
    let factor = SHARE_TICKS as f64 * TICK_S / total.as_secs_f64();
    println!(
        "{label}: {factor:.1} x real time, {:.0} us per tick",
        total.as_secs_f64() / SHARE_TICKS as f64 * 1e6
    );
    for (stage, time) in spent {
        println!("  {stage:8} {:5.2} %", 100.0 * time.as_secs_f64() / total.as_secs_f64());
    }
}

fn closed_loop(c: &mut Criterion) {
    let cases: [(&str, &str, &[&str]); 2] = [
        ("free_flight", "scenarios/hover.toml", &[]),
        (
            "grasp",
            "scenarios/reset_demo.toml",
            &["disturbances=[]", "predictor.kind=random_features"],
        ),
    ];
    let mut group = c.benchmark_group("tick");
    // One element is one simulated second: the throughput is the real-time factor.
    group
        .throughput(Throughput::Elements(1))
        .sample_size(20)
        .measurement_time(Duration::from_secs(5));
    for (label, file, overrides) in cases {
        let mut flight = flight(file, overrides);
        for _ in 0..100 {
            flight.tick();
        }
        shares(label, &mut flight);
        group.bench_function(format!("{label}_100_ticks"), |b| {
            b.iter(|| (0..100).for_each(|_| drop(flight.tick())));
        });
    }
    group.finish();
}

criterion_group!(benches, closed_loop);
criterion_main!(benches);
