//! Windows of a flight as inputs of a linear model.
//!
//! In: ticks. Out: per tick `t` a column of inputs that ends with `chi_t`, `chi_dot_t`, `tau_{t-1}` and `r_{t-1}`, as a predictor sees them,
//! and the residuals `r_{t+h}` to foresee. The newest [`SHORT`] ticks come first, each for itself; the older ones up to [`LONG`] follow as
//! means of [`BLOCK`] ticks. So the inputs of the short window are the first ones of the long window.

use nalgebra::DMatrix;

use super::super::series::ReplayTick;
use twin_core::elementary::squared;
use twin_core::notation::N;

/// Ticks ahead of the current one: 0, 60, 100 and 200 ms. The newest residual is one tick older than the current tick.
pub(super) const HORIZONS_TICKS: [usize; 4] = [0, 6, 10, 20];

/// Ticks of the short window.
pub(super) const SHORT: usize = 10;

/// Ticks of the long window.
pub(super) const LONG: usize = 120;

/// Ticks of each mean of the older part; 50 ms take a thirtieth of the power at 2 Hz, and less below it.
const BLOCK: usize = 5;

/// Coordinates that only give the place and heading of the vehicle; the network does not get them either.
const MASKED: [usize; 3] = [0, 1, 5];

/// Channels of a tick: `chi` without the masked ones, `chi_dot`, `tau_{t-1}`, `r_{t-1}`.
const CHANNELS: usize = 4 * N - MASKED.len();

/// Number of targets: eight coordinates at every horizon.
pub(super) const TARGETS: usize = N * HORIZONS_TICKS.len();

/// Standard deviation below which a channel counts as constant.
const LEAST_STD: f64 = 1e-9;

/// Number of inputs of a window of `ticks`, with the constant input.
pub(super) fn inputs(ticks: usize) -> usize {
    1 + CHANNELS * (SHORT.min(ticks) + ticks.saturating_sub(SHORT) / BLOCK)
}

type Channels = [f64; CHANNELS];

/// The channels of each tick but the first.
fn channels(ticks: &[ReplayTick]) -> Vec<Channels> {
    let of = |(before, now): (&ReplayTick, &ReplayTick)| {
        let chi = (0..N).filter(|i| !MASKED.contains(i)).map(|i| now.chi[i]);
        let rest = [&now.chi_dot, &before.tau, &before.residual];
        let mut all = chi.chain(rest.into_iter().flat_map(|part| part.iter().copied()));
        std::array::from_fn(|_| all.next().unwrap_or_default())
    };
    ticks.iter().zip(ticks.iter().skip(1)).map(of).collect()
}

/// Means and standard deviations of channels and residual over training flights.
pub(super) struct Scale {
    input: [[f64; 2]; CHANNELS],
    pub(super) output: [[f64; 2]; N],
}

impl Scale {
    pub(super) fn of(flights: &[&[ReplayTick]]) -> Self {
        let inputs: Vec<Channels> = flights.iter().flat_map(|ticks| channels(ticks)).collect();
        let residual = flights.iter().flat_map(|ticks| ticks.iter());
        let outputs: Vec<[f64; N]> = residual.map(|tick| tick.residual.into()).collect();
        Self { input: moments(&inputs), output: moments(&outputs) }
    }
}

fn moments<const W: usize>(rows: &[[f64; W]]) -> [[f64; 2]; W] {
    let n = rows.len().max(1) as f64;
    std::array::from_fn(|i| {
        let mean = rows.iter().map(|row| row[i]).sum::<f64>() / n;
        let std = (rows.iter().map(|row| squared(row[i] - mean)).sum::<f64>() / n).sqrt();
        [mean, if std > LEAST_STD { std } else { 1.0 }]
    })
}

/// The z-scored windows of one flight.
pub(super) struct Windows<'a> {
    ticks: &'a [ReplayTick],
    z: Vec<Channels>,
    /// Sums of `z` before each entry.
    sums: Vec<Channels>,
    output: [[f64; 2]; N],
}

impl<'a> Windows<'a> {
    pub(super) fn new(ticks: &'a [ReplayTick], scale: &Scale) -> Self {
        let score = |row: Channels| {
            std::array::from_fn(|i| (row[i] - scale.input[i][0]) / scale.input[i][1])
        };
        let z: Vec<Channels> = channels(ticks).into_iter().map(score).collect();
        let mut sums = Vec::with_capacity(z.len() + 1);
        let mut sum = [0.0; CHANNELS];
        sums.push(sum);
        for row in &z {
            sum = std::array::from_fn(|i| sum[i] + row[i]);
            sums.push(sum);
        }
        Self { ticks, z, sums, output: scale.output }
    }

    /// The ticks at which a long window ends and every horizon is known, without contact and fault from its begin to the last horizon.
    pub(super) fn ends(&self) -> Vec<usize> {
        let last = HORIZONS_TICKS[HORIZONS_TICKS.len() - 1];
        let mut usable = 0;
        let mut ends = Vec::new();
        for (newest, tick) in self.ticks.iter().enumerate() {
            usable = if tick.usable { usable + 1 } else { 0 };
            // One tick more than the window, because its oldest entry has the force of the tick before.
            if usable > LONG + last {
                ends.push(newest - last);
            }
        }
        ends
    }

    /// Writes the inputs of the window that ends at tick `t`.
    pub(super) fn write_inputs(&self, t: usize, mut column: impl FnMut(usize, f64)) {
        let newest = t - 1;
        column(0, 1.0);
        let mut at = 1;
        for entry in (0..SHORT).map(|age| newest - age) {
            for value in self.z[entry] {
                column(at, value);
                at += 1;
            }
        }
        for age in (SHORT..LONG).step_by(BLOCK) {
            let (from, to) = (newest + 1 - age - BLOCK, newest + 1 - age);
            for (before, up_to) in self.sums[from].iter().zip(&self.sums[to]) {
                column(at, (up_to - before) / BLOCK as f64);
                at += 1;
            }
        }
    }

    /// The residual of row `target % N` at horizon `target / N` after tick `t`, z-scored.
    pub(super) fn target(&self, t: usize, target: usize) -> f64 {
        let [mean, std] = self.output[target % N];
        (self.ticks[t + HORIZONS_TICKS[target / N]].residual[target % N] - mean) / std
    }

    /// The newest residual before tick `t`, z-scored.
    pub(super) fn newest_residual(&self, t: usize, row: usize) -> f64 {
        let [mean, std] = self.output[row];
        (self.ticks[t - 1].residual[row] - mean) / std
    }
}

/// Inputs `[inputs, samples]` and targets `[targets, samples]` of the windows that end at `ends`: flight and tick.
pub(super) fn matrices(
    flights: &[Windows<'_>],
    ends: &[(usize, usize)],
) -> (DMatrix<f64>, DMatrix<f64>) {
    let mut x = DMatrix::zeros(inputs(LONG), ends.len());
    for (sample, (flight, t)) in ends.iter().enumerate() {
        let mut column = x.column_mut(sample);
        flights[*flight].write_inputs(*t, |at, value| column[at] = value);
    }
    let y = DMatrix::from_fn(TARGETS, ends.len(), |target, sample| {
        let (flight, t) = ends[sample];
        flights[flight].target(t, target)
    });
    (x, y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::notation::Coords;

    fn tick(i: usize) -> ReplayTick {
        let v = |offset: f64| Coords::from_fn(|row, _| i as f64 + offset + row as f64 * 1e4);
        let (chi, chi_dot, tau, residual) = (v(0.0), v(0.1), v(0.2), v(0.3));
        ReplayTick { t_s: i as f64 * 0.01, chi, chi_dot, tau, residual, usable: i != 150 }
    }

    #[test]
    fn a_window_holds_what_a_predictor_sees_at_its_tick() {
        let ticks: Vec<ReplayTick> = (0..400).map(tick).collect();
        let plain = Scale { input: [[0.0, 1.0]; CHANNELS], output: [[0.0, 1.0]; N] };
        let windows = Windows::new(&ticks, &plain);
        let ends = windows.ends();
        // Ticks 0..150 hold one window of 120 with the tick before it and 20 ticks after its end; tick 150 is in contact.
        assert_eq!((ends[0], ends[9], ends[10]), (120, 129, 271));
        assert_eq!(ends.last(), Some(&(399 - 20)));
        let mut column = vec![f64::NAN; inputs(LONG)];
        windows.write_inputs(120, |at, value| column[at] = value);
        assert!(column.iter().all(|value| value.is_finite()), "every input is written");
        // z is coordinate 2: its own value at t, then the previous residual of the last channel.
        let close = |at: usize, value: f64| (column[at] - value).abs() < 1e-6;
        assert!(close(1, 120.0 + 2e4) && close(CHANNELS, 119.3 + 7e4), "{column:?}");
        assert!(close(1 + CHANNELS, 119.0 + 2e4), "the tick before");
        // The first mean is of the ticks 106..=110, the last of 1..=5.
        assert!(close(inputs(SHORT), 108.0 + 2e4));
        assert!(close(inputs(LONG) - CHANNELS, 3.0 + 2e4));
        // Targets: 0 ms is the tick of the newest coordinates, one after the newest residual.
        assert!((windows.target(120, 0) - 120.3).abs() < 1e-9);
        assert!((windows.newest_residual(120, 0) - 119.3).abs() < 1e-9);
        assert!((windows.target(120, TARGETS - 1) - (140.3 + 7e4)).abs() < 1e-9);
    }
}
