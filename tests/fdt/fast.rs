//! The folded and packed forward pass that flies, compared with the plain one, for every kernel of this processor.

use twin_core::residual::fdt::{Fast, Model, Output};
use twin_core::residual::nn::Precision;
use twin_core::residual::nn::kernels::Kernel;
use twin_core::residual::weights::FdtConfig;

use super::made;

/// Largest difference relative to the largest number, for other orders of summation in single precision.
const ROUNDING: f32 = 1e-5;

/// Largest relative difference if weights are rounded to eight binary digits. Each rounding is at most 0.4 %, and its sign is random.
const BF16: f32 = 3e-2;

fn largest_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let largest = a.iter().fold(1e-3_f32, |most, v| v.abs().max(most));
    a.iter().zip(b).map(|(a, b)| (a - b).abs() / largest).fold(0.0, f32::max)
}

fn differences(a: &Output, b: &Output) -> [f32; 3] {
    [
        largest_difference(&a.residual, &b.residual),
        largest_difference(&a.regime, &b.regime),
        largest_difference(&a.attention, &b.attention),
    ]
}

#[test]
fn every_kernel_gives_the_plain_result_for_every_ablation_and_odd_sizes() {
    let mut configs = made::ablations(FdtConfig::SMALL);
    configs.extend((1..=40).flat_map(|seed| made::ablations(made::odd(seed))));
    for (seed, config) in configs.iter().enumerate() {
        let model = Model::new(&made::weights(config, seed as u64)).expect("weights");
        let x = made::history(config, seed as u64);
        let plain = model.forward(&x);
        for kernel in Kernel::available() {
            let found = Fast::new(&model, kernel, Precision::F32).forward(&x);
            let worst = differences(&plain, &found);
            assert!(worst.iter().all(|d| *d < ROUNDING), "{kernel:?}: {worst:?} of {config:?}");
        }
    }
}

#[test]
fn rounded_weights_change_little_and_the_path_from_the_memory_to_the_regime_least() {
    let model = Model::new(&made::weights(&FdtConfig::SMALL, 5)).expect("weights");
    let x = made::history(&FdtConfig::SMALL, 5);
    let plain = model.forward(&x);
    for kernel in Kernel::available() {
        let mut rounded = Fast::new(&model, kernel, Precision::Bf16);
        let [residual, regime, _] = differences(&plain, &rounded.forward(&x));
        assert!(residual > ROUNDING, "{kernel:?} does not round: {residual}");
        assert!(residual < BF16 && regime < BF16, "{kernel:?}: {residual}, {regime}");
        assert_eq!(rounded.arithmetic(), format!("{}_bf16", kernel.name()));
    }
}

#[test]
fn a_second_history_is_not_coloured_by_the_first() {
    let model = Model::new(&made::weights(&FdtConfig::SMALL, 6)).expect("weights");
    let histories = [1, 2].map(|seed| made::history(&FdtConfig::SMALL, seed));
    let mut fast = Fast::new(&model, Kernel::best(), Precision::F32);
    let first = fast.forward(&histories[0]);
    fast.forward(&histories[1]);
    assert_eq!(fast.forward(&histories[0]), first);
}
