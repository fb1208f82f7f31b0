//! Samples of one quantity over time: checked on entry, interpolated onto ticks, unknown inside gaps.

use nalgebra::{SVector, UnitQuaternion};
use serde::Serialize;

/// Number of median periods above which a hole between two samples is a gap.
const GAP_PERIODS: f64 = 4.0;

/// Share of the median period below which two samples belong to one burst. Arrival times inside a burst say nothing about the
/// time between the measurements.
const BURST_SHARE: f64 = 0.25;

/// Bounds of the gap length, s: a shorter hole is never a gap, a longer hole always is.
const GAP_RANGE_S: (f64, f64) = (0.05, LONGEST_HOLE_S);

/// Length above which every hole is a gap, s.
pub(super) const LONGEST_HOLE_S: f64 = 0.5;

/// Time after a break whose samples are left out, s: two ticks and a half, so that at least one tick is unknown.
const AFTER_BREAK_S: f64 = 0.025;

/// Statistics of the sample times of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Timing {
    /// Number of samples used.
    pub samples: usize,
    /// Samples per second between gaps, Hz.
    pub rate_hz: f64,
    /// Number of holes that count as gaps.
    pub gaps: usize,
    /// Longest hole, s.
    pub longest_gap_s: f64,
    /// Number of samples skipped because their time equals the time of the sample before.
    pub duplicate: usize,
    /// Number of samples skipped because they are earlier than the sample before.
    pub backwards: usize,
    /// Number of samples skipped because a value is not finite.
    pub not_finite: usize,
    /// Number of samples skipped because they repeat the value before exactly, so nothing was measured anew.
    pub repeated: usize,
    /// Number of samples averaged with the sample before, because both arrived in one burst.
    pub merged: usize,
}

/// Samples of `D` numbers in order of time.
#[derive(Clone, Debug)]
pub struct Series<const D: usize> {
    times_s: Vec<f64>,
    values: Vec<SVector<f64, D>>,
    gap_s: f64,
    /// Times at which the value jumped without a motion, s: nothing is interpolated across them.
    breaks_s: Vec<f64>,
    timing: Timing,
}

impl<const D: usize> Default for Series<D> {
    fn default() -> Self {
        Self {
            times_s: Vec::new(),
            values: Vec::new(),
            gap_s: GAP_RANGE_S.1,
            breaks_s: Vec::new(),
            timing: Timing::default(),
        }
    }
}

impl<const D: usize> Series<D> {
    /// A series of these samples. It skips and counts samples that run backwards, repeat a time or are not finite.
    pub fn new(samples: impl Iterator<Item = (f64, SVector<f64, D>)>) -> Self {
        let mut series = Self::default();
        for (t_s, value) in samples {
            let last = series.times_s.last().copied();
            if !(t_s.is_finite() && value.iter().all(|v| v.is_finite())) {
                series.timing.not_finite += 1;
            } else if last == Some(t_s) {
                series.timing.duplicate += 1;
            } else if last.is_some_and(|last| t_s < last) {
                series.timing.backwards += 1;
            } else {
                series.times_s.push(t_s);
                series.values.push(value);
            }
        }
        series.merge_bursts();
        series.measure_gaps();
        series
    }

    /// A series as from [`Self::new`] that also skips samples which repeat the value before. A noisy measurement never repeats
    /// exactly, so such a sample was not measured anew. A frozen stream thereby becomes a gap.
    pub fn measured(samples: impl Iterator<Item = (f64, SVector<f64, D>)>) -> Self {
        let mut repeated = 0;
        let mut last: Option<SVector<f64, D>> = None;
        let fresh = samples.filter(|(_, value)| {
            let again = last.as_ref() == Some(value);
            repeated += usize::from(again);
            last = Some(*value);
            !again
        });
        let mut series = Self::new(fresh);
        series.timing.repeated = repeated;
        series
    }

    /// Times between neighbouring samples, s, in ascending order.
    fn periods(&self) -> Vec<f64> {
        let mut periods: Vec<f64> = self.times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        periods.sort_by(f64::total_cmp);
        periods
    }

    fn merge_bursts(&mut self) {
        let periods = self.periods();
        let Some(median) = periods.get(periods.len() / 2).copied() else { return };
        let (mut times_s, mut values): (Vec<f64>, Vec<SVector<f64, D>>) = (Vec::new(), Vec::new());
        let mut burst = 1.0;
        for (t_s, value) in self.times_s.iter().zip(&self.values) {
            match (times_s.last_mut(), values.last_mut()) {
                (Some(last_s), Some(last)) if t_s - *last_s < BURST_SHARE * median => {
                    burst += 1.0;
                    *last_s += (t_s - *last_s) / burst;
                    *last += (value - *last) / burst;
                    self.timing.merged += 1;
                }
                _ => {
                    burst = 1.0;
                    times_s.push(*t_s);
                    values.push(*value);
                }
            }
        }
        (self.times_s, self.values) = (times_s, values);
    }

    fn measure_gaps(&mut self) {
        let periods = self.periods();
        self.timing.samples = self.times_s.len();
        if periods.is_empty() {
            return;
        }
        let median = periods[periods.len() / 2];
        self.gap_s = (GAP_PERIODS * median).clamp(GAP_RANGE_S.0, GAP_RANGE_S.1);
        let first_gap = periods.partition_point(|period| *period <= self.gap_s);
        let filled_s: f64 = periods[..first_gap].iter().sum();
        self.timing.rate_hz = if filled_s > 0.0 { first_gap as f64 / filled_s } else { 0.0 };
        self.timing.gaps = periods.len() - first_gap;
        self.timing.longest_gap_s = *periods.last().unwrap_or(&0.0);
    }

    /// Breaks the series at these times, s, in ascending order: nothing is interpolated across a break, and the samples of the first
    /// 25 ms after it are left out, so that a tick lies inside.
    pub fn break_at(&mut self, breaks_s: &[f64]) {
        let inside = |t_s: f64| breaks_s.iter().any(|at| (*at..at + AFTER_BREAK_S).contains(&t_s));
        let keep: Vec<bool> = self.times_s.iter().map(|t_s| !inside(*t_s)).collect();
        let mut kept = keep.iter();
        self.values.retain(|_| kept.next().copied().unwrap_or(true));
        let mut kept = keep.iter();
        self.times_s.retain(|_| kept.next().copied().unwrap_or(true));
        self.breaks_s = breaks_s.to_vec();
    }

    /// Whether a break lies between sample `i` and the next one.
    fn is_broken(&self, i: usize) -> bool {
        let after = self.breaks_s.partition_point(|at| *at <= self.times_s[i]);
        self.breaks_s.get(after).is_some_and(|at| self.times_s.get(i + 1).is_some_and(|t| at <= t))
    }

    /// Times of the samples, s.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Statistics of the sample times.
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// Statistics of the sample times, without the gaps that overlap the intervals `unread_s` (s), which were not read.
    pub fn timing_read(&self, unread_s: &[(f64, f64)]) -> Timing {
        if unread_s.is_empty() {
            return self.timing;
        }
        let reaches =
            |pair: &&[f64]| !unread_s.iter().any(|(from, to)| pair[0] < *to && pair[1] > *from);
        let periods = || self.times_s.windows(2).filter(reaches).map(|pair| pair[1] - pair[0]);
        Timing {
            gaps: periods().filter(|period| *period > self.gap_s).count(),
            longest_gap_s: periods().fold(0.0, f64::max),
            ..self.timing
        }
    }

    /// First and last time, s.
    pub fn span(&self) -> Option<(f64, f64)> {
        Some((*self.times_s.first()?, *self.times_s.last()?))
    }

    /// True if all samples are zero.
    pub fn all_zero(&self) -> bool {
        self.values.iter().all(|value| value.iter().all(|v| *v == 0.0))
    }

    /// Values in order of time.
    pub fn values(&self) -> &[SVector<f64, D>] {
        &self.values
    }

    /// Index of the sample before `t_s` and the fraction of the way to the next; `None` outside of the series and inside gaps.
    fn bracket(&self, t_s: f64) -> Option<(usize, f64)> {
        let after = self.times_s.partition_point(|t| *t <= t_s);
        let before = after.checked_sub(1)?;
        let start = self.times_s[before];
        if after == self.times_s.len() {
            return (t_s <= start).then_some((before, 0.0));
        }
        let period = self.times_s[after] - start;
        // A time exactly on a sample needs no interpolation.
        if period > self.gap_s || self.is_broken(before) {
            return (t_s <= start).then_some((before, 0.0));
        }
        Some((before, (t_s - start) / period))
    }

    /// Linear interpolation at `t_s`; `None` outside of the series and inside gaps.
    pub fn linear(&self, t_s: f64) -> Option<SVector<f64, D>> {
        let (i, u) = self.bracket(t_s)?;
        if u == 0.0 {
            return Some(self.values[i]);
        }
        Some(self.values[i] * (1.0 - u) + self.values[i + 1] * u)
    }

    /// Cubic Hermite interpolation with three-point slopes at `t_s`; `None` outside of the series and inside gaps. Its second
    /// derivative does not beat with the tick, as that of linear interpolation does.
    pub fn cubic(&self, t_s: f64) -> Option<SVector<f64, D>> {
        let (i, u) = self.bracket(t_s)?;
        if u == 0.0 {
            return Some(self.values[i]);
        }
        let period = self.times_s[i + 1] - self.times_s[i];
        let (m0, m1) = (self.slope(i) * period, self.slope(i + 1) * period);
        let (u2, u3) = (u * u, u * u * u);
        Some(
            self.values[i] * (2.0 * u3 - 3.0 * u2 + 1.0)
                + m0 * (u3 - 2.0 * u2 + u)
                + self.values[i + 1] * (3.0 * u2 - 2.0 * u3)
                + m1 * (u3 - u2),
        )
    }

    /// Slope at sample `i`, per s, from the neighbours that no gap separates from it.
    fn slope(&self, i: usize) -> SVector<f64, D> {
        let step = |a: usize| {
            let b = a + 1;
            let period = self.times_s.get(b)? - self.times_s.get(a)?;
            (period <= self.gap_s && !self.is_broken(a))
                .then(|| ((self.values[b] - self.values[a]) / period, period))
        };
        match (i.checked_sub(1).and_then(step), step(i)) {
            (Some((d0, h0)), Some((d1, h1))) => (d0 * h1 + d1 * h0) / (h0 + h1),
            (Some((d, _)), None) | (None, Some((d, _))) => d,
            (None, None) => SVector::zeros(),
        }
    }
}

/// Attitude over time: quaternions with consistent signs, interpolated by SLERP.
#[derive(Clone, Debug, Default)]
pub struct Attitudes {
    raw: Series<4>,
    /// Number of times that the sign of the quaternion jumped.
    pub sign_flips: usize,
}

impl Attitudes {
    /// Attitudes of `world_from_body`, in order of time.
    pub fn new(samples: impl Iterator<Item = (f64, UnitQuaternion<f64>)>) -> Self {
        let mut last: Option<SVector<f64, 4>> = None;
        let mut sign_flips = 0;
        let raw = Series::measured(samples.map(|(t_s, q)| {
            let mut coords = q.into_inner().coords;
            if last.is_some_and(|last| last.dot(&coords) < 0.0) {
                coords = -coords;
                sign_flips += 1;
            }
            last = Some(coords);
            (t_s, coords)
        }));
        Self { raw, sign_flips }
    }

    /// Statistics of the sample times.
    pub fn timing(&self) -> Timing {
        self.raw.timing
    }

    /// Statistics of the sample times, without the gaps that overlap the intervals `unread_s` (s), which were not read.
    pub fn timing_read(&self, unread_s: &[(f64, f64)]) -> Timing {
        self.raw.timing_read(unread_s)
    }

    /// First and last time, s.
    pub fn span(&self) -> Option<(f64, f64)> {
        self.raw.span()
    }

    /// Breaks the attitudes as [`Series::break_at`] does.
    pub fn break_at(&mut self, breaks_s: &[f64]) {
        self.raw.break_at(breaks_s);
    }

    /// Times in s and unit quaternions of the samples.
    pub fn samples(&self) -> impl Iterator<Item = (f64, UnitQuaternion<f64>)> + '_ {
        let turn = |v: &SVector<f64, 4>| UnitQuaternion::from_quaternion((*v).into());
        self.raw.times_s.iter().copied().zip(self.raw.values.iter().map(turn))
    }

    /// Attitude at `t_s`; `None` outside of the series and inside gaps.
    pub fn slerp(&self, t_s: f64) -> Option<UnitQuaternion<f64>> {
        let (i, u) = self.raw.bracket(t_s)?;
        let at = |i: usize| UnitQuaternion::from_quaternion(self.raw.values[i].into());
        if u == 0.0 {
            return Some(at(i));
        }
        Some(at(i).try_slerp(&at(i + 1), u, f64::EPSILON).unwrap_or_else(|| at(i)))
    }
}

#[cfg(test)]
#[path = "series_tests.rs"]
mod tests;
