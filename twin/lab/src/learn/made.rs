//! Made flights for tests: a linear system whose residual is a known function of its inputs.

use super::config::TrainConfig;
use super::dataset::{Dataset, FlightSeries};
use twin_core::elementary::sin;

/// Flights whose z-scored residual is `r_x = 0.8 tau_x - 0.5 chi_dot_x` and `r_z = 3 + 0.6 tau_z`, smooth in time.
pub(super) fn dataset(flights: usize, ticks: usize) -> Dataset {
    let names = ["chi.x", "chi_dot.x", "tau.x", "tau.z"].map(str::to_owned).to_vec();
    let one = |flight: usize| {
        let wave = |rate: f64, phase: f64| -> Vec<f32> {
            let at = |t: usize| sin(rate * t as f64 + phase + 1.7 * flight as f64) as f32;
            (0..ticks).map(at).collect()
        };
        let (v, fx, fz) = (wave(0.05, 0.3), wave(0.083, 1.1), wave(0.031, 2.0));
        let x = v.iter().zip(&fx).map(|(v, f)| 0.8 * f - 0.5 * v).collect();
        let z = fz.iter().map(|f| 3.0 + 0.6 * f).collect();
        FlightSeries {
            name: format!("made {flight}"),
            inputs: vec![vec![0.1; ticks], v, fx, fz],
            outputs: vec![x, z],
            usable: vec![true; ticks],
        }
    };
    Dataset {
        channel_names: names,
        output_names: vec!["x".to_owned(), "z".to_owned()],
        nominal_inertia: vec![2.0, 2.0],
        flights: (0..flights).map(one).collect(),
        left_out: Vec::new(),
    }
}

/// A configuration that trains in a second.
pub(super) fn tiny() -> TrainConfig {
    TrainConfig {
        d_model: 16,
        heads: 2,
        d_ff: 32,
        d_k: 8,
        layers: 1,
        t_long: 20,
        horizon: 2,
        epochs: 4,
        batch: 32,
        stride: 2,
        learning_rate: 3e-3,
        tau_noise: 0.05,
        validation: 0.2,
        ..TrainConfig::default()
    }
}
