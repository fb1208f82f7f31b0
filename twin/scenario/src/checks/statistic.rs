//! Statistics of the samples of a window, and the time from which a statistic could no longer keep its limits.

use serde::{Deserialize, Serialize};

/// A statistic of samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Statistic {
    /// The largest sample.
    #[default]
    Max,
    /// The smallest sample.
    Min,
    /// The root of the mean of the squares.
    Rms,
    /// The sample below which a share of all samples lies (nearest rank).
    Quantile,
    /// The last sample.
    Final,
}

impl Statistic {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Max => "max",
            Self::Min => "min",
            Self::Rms => "rms",
            Self::Quantile => "quantile",
            Self::Final => "final",
        }
    }

    /// Value of the statistic; `None` without samples, NaN if a sample is NaN.
    pub(super) fn value(self, samples: &[(f64, f64)], quantile: f64) -> Option<f64> {
        let (_, last) = *samples.last()?;
        let values = || samples.iter().map(|(_, value)| *value);
        if self != Self::Final && values().any(f64::is_nan) {
            return Some(f64::NAN);
        }
        Some(match self {
            Self::Max => values().fold(f64::NEG_INFINITY, f64::max),
            Self::Min => values().fold(f64::INFINITY, f64::min),
            Self::Rms => (values().map(|v| v * v).sum::<f64>() / samples.len() as f64).sqrt(),
            Self::Quantile => {
                let mut sorted: Vec<f64> = values().collect();
                sorted.sort_by(f64::total_cmp);
                sorted[rank(sorted.len(), quantile)]
            }
            Self::Final => last,
        })
    }

    /// Time of the sample from which no later sample could have kept the limits, s; `None` if the limits are kept.
    pub(super) fn breach(
        self,
        samples: &[(f64, f64)],
        quantile: f64,
        min: Option<f64>,
        max: Option<f64>,
    ) -> Option<f64> {
        let (last_s, _) = *samples.last()?;
        let value = self.value(samples, quantile)?;
        if value.is_nan() {
            let first = samples.iter().find(|(_, v)| v.is_nan());
            return Some(first.map_or(last_s, |(t_s, _)| *t_s));
        }
        let high = max.filter(|max| value > *max).map(|max| self.exceeded(samples, quantile, max));
        let low = min.filter(|min| value < *min).map(|min| self.undercut(samples, quantile, min));
        match (low.map(|t_s| t_s.unwrap_or(last_s)), high.map(|t_s| t_s.unwrap_or(last_s))) {
            (Some(low), Some(high)) => Some(low.min(high)),
            (low, high) => low.or(high),
        }
    }

    fn exceeded(self, samples: &[(f64, f64)], quantile: f64, max: f64) -> Option<f64> {
        let mut beyond = samples.iter().filter(|(_, v)| *v > max).map(|(t_s, _)| *t_s);
        match self {
            Self::Max => beyond.next(),
            Self::Quantile => beyond.nth(samples.len() - rank(samples.len(), quantile) - 1),
            Self::Rms => {
                let allowed = max * max * samples.len() as f64;
                let mut sum = 0.0;
                let spent = samples.iter().find(|(_, v)| {
                    sum += v * v;
                    sum > allowed
                });
                spent.map(|(t_s, _)| *t_s)
            }
            Self::Min | Self::Final => None,
        }
    }

    fn undercut(self, samples: &[(f64, f64)], quantile: f64, min: f64) -> Option<f64> {
        let mut beyond = samples.iter().filter(|(_, v)| *v < min).map(|(t_s, _)| *t_s);
        match self {
            Self::Min => beyond.next(),
            Self::Quantile => beyond.nth(rank(samples.len(), quantile)),
            Self::Max | Self::Rms | Self::Final => None,
        }
    }
}

/// Index of the quantile among `count` sorted samples.
fn rank(count: usize, quantile: f64) -> usize {
    ((count.saturating_sub(1)) as f64 * quantile.clamp(0.0, 1.0)).round() as usize
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const ALL: [Statistic; 5] =
        [Statistic::Max, Statistic::Min, Statistic::Rms, Statistic::Quantile, Statistic::Final];

    fn timed(values: &[f64]) -> Vec<(f64, f64)> {
        values.iter().enumerate().map(|(i, v)| (i as f64, *v)).collect()
    }

    #[test]
    fn each_statistic_of_a_small_sample_is_the_one_worked_out_by_hand() {
        let samples = timed(&[3.0, -1.0, 2.0, 5.0, 4.0]);
        let value = |statistic: Statistic, q| statistic.value(&samples, q).unwrap();
        assert!((value(Statistic::Max, 1.0) - 5.0).abs() < f64::EPSILON);
        assert!((value(Statistic::Min, 1.0) + 1.0).abs() < f64::EPSILON);
        // 9 + 1 + 4 + 25 + 16 = 55, over 5 samples.
        assert!((value(Statistic::Rms, 1.0) - 11.0_f64.sqrt()).abs() < 1e-12);
        // Sorted: -1 2 3 4 5; three quarters of the way is 4.
        assert!((value(Statistic::Quantile, 0.75) - 4.0).abs() < f64::EPSILON);
        assert!((value(Statistic::Final, 1.0) - 4.0).abs() < f64::EPSILON);
        assert_eq!(Statistic::Max.value(&[], 1.0), None);
    }

    #[test]
    fn the_breach_is_the_first_instant_at_which_nothing_could_save_the_bound() {
        let samples = timed(&[1.0, 1.0, 6.0, 7.0, 1.0]);
        let at = |statistic: Statistic, q, max| statistic.breach(&samples, q, None, Some(max));
        assert_eq!(at(Statistic::Max, 1.0, 5.0), Some(2.0));
        assert_eq!(at(Statistic::Max, 1.0, 7.0), None);
        // Four fifths may lie below 5. The median does; the 0.75 quantile (rank 3 of 0..=4) needs two samples above.
        assert_eq!(at(Statistic::Quantile, 0.5, 5.0), None);
        assert_eq!(at(Statistic::Quantile, 0.75, 5.0), Some(3.0));
        // The limit 3² × 5 = 45 allows 1 + 1 + 36 = 38, but not 49 more.
        assert_eq!(at(Statistic::Rms, 1.0, 3.0), Some(3.0));
        assert_eq!(at(Statistic::Final, 1.0, 0.5), Some(4.0));
        assert_eq!(Statistic::Max.breach(&samples, 1.0, Some(9.0), None), Some(4.0));
        let broken = timed(&[1.0, f64::NAN, 1.0]);
        assert_eq!(Statistic::Rms.breach(&broken, 1.0, None, Some(9.0)), Some(1.0));
    }

    proptest! {
        #[test]
        fn a_breach_is_found_exactly_when_the_value_is_outside(
            values in prop::collection::vec(-10.0..10.0_f64, 1..60),
            quantile in 0.0..=1.0_f64,
            min in -10.0..0.0_f64,
            max in 0.0..10.0_f64,
        ) {
            let samples = timed(&values);
            for statistic in ALL {
                let value = statistic.value(&samples, quantile).unwrap();
                let at = statistic.breach(&samples, quantile, Some(min), Some(max));
                prop_assert_eq!(at.is_some(), !(min..=max).contains(&value), "{:?}", statistic);
                // Before that time samples of 0 could still have kept the bound, if the bound allows 0.
                if let (Some(at), Statistic::Max | Statistic::Quantile | Statistic::Rms) = (at, statistic)
                    && value > max
                {
                    let mut saved = samples.clone();
                    saved.iter_mut().filter(|(t_s, _)| *t_s >= at).for_each(|(_, v)| *v = 0.0);
                    prop_assert!(statistic.value(&saved, quantile).unwrap() <= max);
                }
            }
        }

        #[test]
        fn half_of_the_samples_lie_on_each_side_of_the_median(values in prop::collection::vec(-9.0..9.0_f64, 1..60)) {
            let median = Statistic::Quantile.value(&timed(&values), 0.5).unwrap();
            let below = values.iter().filter(|v| **v < median).count();
            let above = values.iter().filter(|v| **v > median).count();
            prop_assert!(below * 2 <= values.len() && above * 2 <= values.len());
        }
    }
}
