//! The table of the residual: its bands, the share of each effect, and how well it is foreseen.
//!
//! In: the measured variants. Out: plain values, with the effects in the order of their total share.

use serde::Serialize;

use super::bands::{BANDS, Split};
use super::conclusion::conclusion;
use super::foreseen::{Foreseen, foreseen};
use super::foresight::MODEL_NAMES;
use super::measured::Measured;
use super::variant::{Flown, Variant};
use twin_core::elementary::squared;
use twin_core::notation::{COORDINATE_NAMES, Coords, N};

/// A coordinate of the residual with everything on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Coordinate.
    pub row: &'static str,
    /// Unit of the residual: N or N m.
    pub unit: &'static str,
    /// Root mean square over the flights of the flight's mean, which belongs to no band, N or N m.
    pub mean: f64,
    /// Variance about the mean of each flight, N² or N² m².
    pub variance: f64,
    /// Variance in each band, N² or N² m².
    pub band_variance: [f64; BANDS],
}

/// The share of the variance that disappears when effects are off: `1 - var(off) / var(on)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Share {
    /// Over all bands.
    pub all: f64,
    /// In each band.
    pub bands: [f64; BANDS],
}

/// The shares of an effect.
#[derive(Clone, Debug, Serialize)]
pub struct Shares {
    /// Which effects were off.
    pub variant: Variant,
    /// Mean over the coordinates of the share over all bands.
    pub total: f64,
    /// Standard deviation (n - 1) of the total over the flights; NaN with one flight.
    pub deviation: f64,
    /// Share of each coordinate.
    pub rows: [Share; N],
}

/// The table.
#[derive(Clone, Debug, Serialize)]
pub struct ResidualTable {
    /// Always `residual`.
    pub table: &'static str,
    /// The command that makes it again.
    pub command: String,
    /// Names of the models of the forecasts.
    pub models: [&'static str; MODEL_NAMES.len()],
    /// Standard deviation of the residual over the training flights with everything on: the unit of z-scores, N and N m.
    pub std: Coords,
    /// The residual with everything on.
    pub rows: Vec<Row>,
    /// Effects in the order of their total share; the last line has all effects off.
    pub effects: Vec<Shares>,
    /// Forecasts with everything on, then in the order of `effects`.
    pub foresight: Vec<Foreseen>,
    /// A sentence about the effect for which the long window helps.
    pub conclusion: String,
    /// All flights.
    pub flights: Vec<Flown>,
}

impl ResidualTable {
    /// The table of `on`, with everything on, and of the `others`, in any order.
    pub fn new(command: String, on: &Measured, others: Vec<Measured>) -> Self {
        let mut effects: Vec<(Shares, Measured)> =
            others.into_iter().map(|off| (shares(on, &off), off)).collect();
        let last = |shares: &Shares| shares.variant == Variant::Off;
        effects.sort_by(|(a, _), (b, _)| last(a).cmp(&last(b)).then(b.total.total_cmp(&a.total)));
        let (effects, others): (Vec<Shares>, Vec<Measured>) = effects.into_iter().unzip();
        let std = on.std;
        let rows = (0..N).map(|i| row(on, i)).collect();
        let measured = || std::iter::once(on).chain(&others);
        let foresight: Vec<Foreseen> = measured().map(|m| foreseen(m, &std)).collect();
        let conclusion = conclusion(&foresight);
        let flights = measured().flat_map(|m| m.flights.clone()).collect();
        Self {
            table: "residual",
            command,
            models: MODEL_NAMES,
            std,
            rows,
            effects,
            foresight,
            conclusion,
            flights,
        }
    }
}

/// `1 - off / on`; NaN if nothing could disappear.
fn share(on: f64, off: f64) -> f64 {
    if on > 0.0 { 1.0 - off / on } else { f64::NAN }
}

fn shares(on: &Measured, off: &Measured) -> Shares {
    let rows: [Share; N] = std::array::from_fn(|row| {
        let (on, off) = (on.variance(row), off.variance(row));
        Share {
            all: share(on.iter().sum(), off.iter().sum()),
            bands: std::array::from_fn(|band| share(on[band], off[band])),
        }
    });
    let of_flight = |(on, off): (&[Split; N], &[Split; N])| {
        let each = on.iter().zip(off);
        let all = |split: &Split| split.variance.iter().sum::<f64>();
        each.map(|(on, off)| share(all(on), all(off))).sum::<f64>() / N as f64
    };
    let totals: Vec<f64> = on.splits.iter().zip(&off.splits).map(of_flight).collect();
    let n = totals.len() as f64;
    let mean = totals.iter().sum::<f64>() / n;
    let squares = totals.iter().map(|total| squared(total - mean)).sum::<f64>();
    Shares {
        variant: off.variant,
        total: rows.iter().map(|row| row.all).sum::<f64>() / N as f64,
        deviation: (squares / (n - 1.0)).sqrt(),
        rows,
    }
}

fn row(on: &Measured, i: usize) -> Row {
    let band_variance = on.variance(i);
    Row {
        row: COORDINATE_NAMES[i],
        unit: if i < 3 { "N" } else { "N m" },
        mean: on.mean(i),
        variance: band_variance.iter().sum(),
        band_variance,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::foresight::Foresight;
    use super::super::windows::HORIZONS_TICKS;
    use super::*;
    use twin_scenario::Verdict;

    /// A variant with two flights of these variances in every coordinate; `rmse` by model, at every horizon.
    pub(in super::super) fn measured(
        variant: Variant,
        variances: [[f64; BANDS]; 2],
        rmse: [f64; 3],
    ) -> Measured {
        let flown = |seed: u64| Flown {
            scenario: "s".to_owned(),
            seed,
            variant,
            verdict: Verdict::Completed,
            reason: String::new(),
            ticks: 100,
        };
        Measured {
            variant,
            flights: vec![flown(1), flown(2)],
            splits: variances.map(|variance| [Split { mean: 2.0, variance }; N]).to_vec(),
            std: Coords::repeat(2.0),
            foresight: Foresight {
                rmse: rmse.map(|value| [Coords::repeat(value); HORIZONS_TICKS.len()]),
                ridge: Some([1e-6, 1e-4]),
                samples: [10, 5],
            },
        }
    }

    /// A table in which `big` explains half of the variance and the help of the long window, and `small` nothing.
    pub(in super::super) fn table() -> ResidualTable {
        let on = measured(Variant::On, [[4.0, 2.0, 2.0]; 2], [1.0, 0.5, 0.4]);
        let small = measured(Variant::Without("small"), [[4.0, 2.0, 2.2]; 2], [1.0, 0.5, 0.4]);
        let big =
            measured(Variant::Without("big"), [[1.0, 2.0, 1.0], [0.0, 2.0, 2.0]], [0.8, 0.4, 0.4]);
        let off = measured(Variant::Off, [[0.0, 2.0, 1.0]; 2], [0.6, 0.3, 0.3]);
        ResidualTable::new("twin evaluate residual".to_owned(), &on, vec![small, off, big])
    }

    /// Roundings of numbers near 1.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn a_share_is_the_variance_that_disappears() {
        let table = table();
        let names: Vec<Variant> = table.effects.iter().map(|e| e.variant).collect();
        assert_eq!(names, [Variant::Without("big"), Variant::Without("small"), Variant::Off]);
        let big = &table.effects[0];
        // 4 of 8 remain in both flights. Of the lowest band 0.5 of 4 remain on average, of the highest 1.5 of 2.
        assert!((big.total - 0.5).abs() < ROUNDING && big.deviation < ROUNDING);
        for (found, expected) in big.rows[3].bands.iter().zip([0.875, 0.0, 0.25]) {
            assert!((found - expected).abs() < ROUNDING, "{big:?}");
        }
        // More variance without the effect is a negative share.
        assert!((table.effects[1].total + 0.025).abs() < ROUNDING);
    }

    #[test]
    fn errors_are_in_standard_deviations_with_everything_on() {
        let table = table();
        let without = &table.foresight[1];
        assert_eq!(without.variant, Variant::Without("big"));
        assert!((without.horizons[0].rmse_z[0] - 0.4).abs() < ROUNDING);
        assert!((without.ratio() - 1.0).abs() < ROUNDING);
        assert!((table.foresight[0].ratio() - 0.8).abs() < ROUNDING);
        assert!((table.rows[0].mean - 2.0).abs() < ROUNDING);
    }
}
