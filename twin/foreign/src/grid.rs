//! Values on the 100 Hz ticks of a flight, `None` where unknown, with derivatives and the filter `H` over runs of known ticks.

use nalgebra::SVector;

use twin_core::filter::Butterworth;
use twin_core::notation::TICK_S;

/// Corner frequency of `H`, Hz.
const CORNER_HZ: f64 = 8.0;

/// Ticks that the filter takes to settle after the start of a run: two periods of its corner frequency.
pub(super) const SETTLE_TICKS: usize = 25;

/// One value per tick; `None` is unknown.
pub(super) type Ticks<const D: usize> = Vec<Option<SVector<f64, D>>>;

/// Central difference per tick, per s; one-sided at the ends of a run, unknown for a single tick.
pub(super) fn slope<const D: usize>(values: &Ticks<D>) -> Ticks<D> {
    let at = |i: Option<usize>| i.and_then(|i| values.get(i).copied().flatten());
    (0..values.len())
        .map(|i| {
            let here = values[i]?;
            match (at(i.checked_sub(1)), at(Some(i + 1))) {
                (Some(before), Some(after)) => Some((after - before) / (2.0 * TICK_S)),
                (Some(before), None) => Some((here - before) / TICK_S),
                (None, Some(after)) => Some((after - here) / TICK_S),
                (None, None) => None,
            }
        })
        .collect()
}

/// Second central difference per tick, per s²; unknown at the ends of a run.
pub(super) fn curvature<const D: usize>(values: &Ticks<D>) -> Ticks<D> {
    (0..values.len())
        .map(|i| {
            let before = values[i.checked_sub(1)?]?;
            let after = (*values.get(i + 1)?)?;
            Some((after - values[i]? * 2.0 + before) / (TICK_S * TICK_S))
        })
        .collect()
}

/// Applies [`filtered`] `passes` times.
pub(super) fn filtered_times<const D: usize>(values: &Ticks<D>, passes: usize) -> Ticks<D> {
    (0..passes).fold(values.clone(), |values, _| filtered(&values, true))
}

/// Filters with `H` at the tick rate and restarts at every run of known ticks. With `settled`, the ticks during which the filter
/// settles are unknown.
pub(super) fn filtered<const D: usize>(values: &Ticks<D>, settled: bool) -> Ticks<D> {
    let mut filter: Option<(Butterworth<D>, usize)> = None;
    values
        .iter()
        .map(|value| {
            let Some(value) = value else {
                filter = None;
                return None;
            };
            let (filter, age) = filter.get_or_insert_with(|| {
                let mut fresh = Butterworth::new(CORNER_HZ, TICK_S);
                fresh.settle(value);
                (fresh, 0)
            });
            let out = filter.step(value);
            *age += 1;
            (!settled || *age > SETTLE_TICKS).then_some(out)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;
    use twin_core::elementary::squared;

    #[test]
    fn derivatives_of_a_parabola_are_exact_and_stop_at_a_gap() {
        let f = |i: usize| Vector1::new(0.5 * 3.0 * squared(i as f64 * TICK_S));
        let values: Ticks<1> = (0..100).map(|i| (!(40..50).contains(&i)).then(|| f(i))).collect();
        let (rate, acceleration) = (slope(&values), curvature(&values));
        for i in [1, 20, 38, 51, 98] {
            // Rounding of a difference of numbers near 1, divided by 1e-4.
            assert!((rate[i].unwrap().x - 3.0 * i as f64 * TICK_S).abs() < 1e-9);
            assert!((acceleration[i].unwrap().x - 3.0).abs() < 1e-9);
        }
        for i in [0, 39, 45, 50, 99] {
            assert_eq!(acceleration[i], None, "{i}");
        }
        assert_eq!(rate[45], None);
    }

    #[test]
    fn the_filter_starts_anew_after_a_gap_and_says_when_it_has_settled() {
        let values: Ticks<1> = (0..100)
            .map(|i| (i != 50).then(|| Vector1::new(if i < 50 { 1.0 } else { 9.0 })))
            .collect();
        let out = filtered(&values, true);
        assert_eq!(out[SETTLE_TICKS - 1], None);
        assert!((out[40].unwrap().x - 1.0).abs() < 1e-12);
        assert_eq!(out[50 + SETTLE_TICKS], None);
        // The filter contains nothing of the values before the gap.
        assert!((out[51 + SETTLE_TICKS].unwrap().x - 9.0).abs() < 1e-12);
    }
}
