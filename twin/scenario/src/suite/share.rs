//! The confidence interval of a share of successes.

/// Standard normal quantile of a two-sided 95 % interval.
const Z_95: f64 = 1.959_963_984_540_054;

/// Wilson's 95 % interval of the success probability after `successes` of `trials`; 0 to 1 if there was no trial.
pub fn wilson_95(successes: usize, trials: usize) -> (f64, f64) {
    if trials == 0 {
        return (0.0, 1.0);
    }
    let n = trials as f64;
    let share = successes as f64 / n;
    let z2 = Z_95 * Z_95;
    let centre = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z_95 / (1.0 + z2 / n) * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    ((centre - half).max(0.0), (centre + half).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::elementary::squared;

    #[test]
    fn the_interval_solves_wilsons_equation_and_holds_the_share() {
        for (successes, trials) in [(0, 10), (10, 10), (9, 10), (50, 200), (199, 200), (1, 1)] {
            let (low, high) = wilson_95(successes, trials);
            let (n, share) = (trials as f64, successes as f64 / trials as f64);
            // The comparisons hold up to rounding.
            assert!(low >= 0.0 && low <= share + 1e-12 && share <= high + 1e-12 && high <= 1.0);
            // At each end of the interval the share is 1.96 standard errors away; at 0 and 1 one end is the share itself.
            for end in [low, high] {
                let distance = squared(share - end) - squared(Z_95) * end * (1.0 - end) / n;
                assert!(distance.abs() < 1e-12, "{successes}/{trials}: {end}");
            }
        }
        // Brown, Cai and DasGupta (2001): 0 of 10 reaches to 0.2775.
        assert!((wilson_95(0, 10).1 - 0.2775).abs() < 5e-5);
        assert!(wilson_95(0, 0) == (0.0, 1.0));
    }
}
