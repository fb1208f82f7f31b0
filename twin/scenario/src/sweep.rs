//! The `[sweep]` of a scenario: the keys that vary, their ranges, and the samples.
//!
//! In: the settings. Out: for every sample the values of its keys. The same settings give the same samples on every machine.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use super::checks::CheckError;

/// Largest number of samples of a sweep.
const MOST_SAMPLES: usize = 100_000;

/// A sweep: many flights of a scenario, each with other values of some keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// How the samples fill the ranges.
    #[serde(default)]
    pub method: Method,
    /// Number of samples; a `grid` takes the product of its steps instead and must not have it.
    pub samples: Option<usize>,
    /// Seed of the random samples.
    #[serde(default)]
    pub seed: u64,
    /// Share of the samples that must succeed.
    pub min_success: f64,
    /// True if the lower end of the 95 % interval must reach that share, not only the share itself.
    #[serde(default)]
    pub confident: bool,
    /// The keys that vary, with their ranges.
    pub ranges: Vec<Range>,
}

/// How the samples fill the ranges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Every combination of the steps of all ranges.
    Grid,
    /// A Latin hypercube: every range has as many strata as there are samples, and each stratum has one sample.
    #[default]
    LatinHypercube,
}

/// A key and its values: a list, or an interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// Dotted key; a number is an index in a list (`wind.velocity_m_s.0`).
    pub key: String,
    /// Smallest value.
    pub from: Option<f64>,
    /// Largest value.
    pub to: Option<f64>,
    /// Number of values that a grid takes from the interval, both ends included.
    pub steps: Option<usize>,
    /// The list of values.
    pub values: Option<Vec<f64>>,
}

/// Values of one sample, in the order of the ranges.
pub type Values = Vec<f64>;

impl Range {
    /// The value at the position `part`, `0..1`, of the range.
    fn at(&self, part: f64) -> f64 {
        match (&self.values, self.from, self.to) {
            (Some(values), ..) => {
                let index = (part * values.len() as f64) as usize;
                values.get(index.min(values.len().saturating_sub(1))).copied().unwrap_or(0.0)
            }
            (None, from, to) => {
                let (from, to) = (from.unwrap_or(0.0), to.unwrap_or(0.0));
                from + part * (to - from)
            }
        }
    }

    fn steps(&self) -> usize {
        self.values.as_ref().map_or(self.steps.unwrap_or(0), Vec::len)
    }

    fn step(&self, index: usize) -> f64 {
        let count = self.steps();
        match &self.values {
            Some(values) => values.get(index).copied().unwrap_or(0.0),
            None if count < 2 => self.at(0.0),
            None => self.at(index as f64 / (count - 1) as f64),
        }
    }
}

impl Sweep {
    /// Number of samples.
    pub fn count(&self) -> usize {
        match self.method {
            Method::Grid => self
                .ranges
                .iter()
                .map(Range::steps)
                .try_fold(1_usize, usize::checked_mul)
                .unwrap_or(usize::MAX),
            Method::LatinHypercube => self.samples.unwrap_or(0),
        }
    }

    /// The samples of the sweep in these `settings`. Values are rounded to six decimal places, and to whole numbers where the
    /// scenario has a whole number. A flight can therefore be repeated from the text of its sample.
    pub fn samples(&self, settings: &impl Serialize) -> Vec<Values> {
        let tree = toml::Value::try_from(settings).ok();
        let whole: Vec<bool> = self
            .ranges
            .iter()
            .map(|range| {
                matches!(value_at(tree.as_ref(), &range.key), Some(toml::Value::Integer(_)))
            })
            .collect();
        let mut samples = match self.method {
            Method::Grid => self.grid(),
            Method::LatinHypercube => self.latin_hypercube(),
        };
        for sample in &mut samples {
            for (value, whole) in sample.iter_mut().zip(&whole) {
                *value = if *whole { value.round() } else { (*value * 1e6).round() / 1e6 };
            }
        }
        samples
    }

    fn grid(&self) -> Vec<Values> {
        let mut samples = vec![Values::new()];
        for range in &self.ranges {
            let steps = || (0..range.steps()).map(|index| range.step(index));
            samples = samples
                .iter()
                .flat_map(|sample| {
                    steps().map(move |value| sample.iter().copied().chain([value]).collect())
                })
                .collect();
        }
        samples
    }

    /// Draws a Latin hypercube. Source: `McKay`, Beckman and Conover, 1979.
    fn latin_hypercube(&self) -> Vec<Values> {
        let mut rng = Pcg64::seed_from_u64(self.seed);
        let count = self.count();
        let columns: Vec<Vec<f64>> = self
            .ranges
            .iter()
            .map(|range| {
                let mut strata: Vec<usize> = (0..count).collect();
                strata.shuffle(&mut rng);
                strata
                    .into_iter()
                    .map(|stratum| range.at((stratum as f64 + rng.random::<f64>()) / count as f64))
                    .collect()
            })
            .collect();
        (0..count).map(|index| columns.iter().map(|column| column[index]).collect()).collect()
    }
}

/// The value at a dotted key.
fn value_at<'a>(tree: Option<&'a toml::Value>, key: &str) -> Option<&'a toml::Value> {
    key.split('.').try_fold(tree?, |value, segment| match value {
        toml::Value::Table(table) => table.get(segment),
        toml::Value::Array(list) => list.get(segment.parse::<usize>().ok()?),
        _ => None,
    })
}

/// Checks whether the sweep of these `settings` can be flown and can fail.
pub(super) fn validate(sweep: &Sweep, settings: &impl Serialize) -> Result<(), CheckError> {
    let refuse = |key: String, reason: &str| Err(CheckError { key, reason: reason.to_owned() });
    if !(sweep.min_success > 0.0 && sweep.min_success <= 1.0) {
        return refuse(
            "sweep.min_success".into(),
            "expected a share above 0 and up to 1, else the sweep cannot fail",
        );
    }
    if sweep.ranges.is_empty() {
        return refuse("sweep.ranges".into(), "no range is given, so no key varies");
    }
    if sweep.method == Method::Grid && sweep.samples.is_some() {
        return refuse("sweep.samples".into(), "a grid has as many samples as its steps make");
    }
    if !(1..=MOST_SAMPLES).contains(&sweep.count()) {
        let reason =
            format!("the sweep has {} samples, expected 1..={MOST_SAMPLES}", sweep.count());
        return refuse("sweep.samples".into(), &reason);
    }
    let tree = toml::Value::try_from(settings).ok();
    for (index, range) in sweep.ranges.iter().enumerate() {
        let key = |name: &str| format!("sweep.ranges.{index}.{name}");
        let number = matches!(
            value_at(tree.as_ref(), &range.key),
            Some(toml::Value::Integer(_) | toml::Value::Float(_))
        );
        if !number && !range.key.starts_with("gains.") {
            let reason = format!("found {:?}, expected the key of a number", range.key);
            return refuse(key("key"), &reason);
        }
        let listed = range.values.as_ref().is_some_and(|values| !values.is_empty());
        let stretch = range.from.zip(range.to).is_some_and(|(from, to)| from <= to);
        if listed == stretch {
            return refuse(key("from"), "expected either `values`, or `from` and `to` above it");
        }
        if sweep.method == Method::Grid && !listed && range.steps.is_none() {
            return refuse(key("steps"), "a grid needs the number of steps");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::settings::Settings;
    use super::*;

    fn range(key: &str, from: f64, to: f64, steps: usize) -> Range {
        let (from, to, steps) = (Some(from), Some(to), Some(steps));
        Range { key: key.into(), from, to, steps, values: None }
    }

    fn sweep(method: Method, samples: Option<usize>) -> Sweep {
        let ranges =
            vec![range("payload.mass_kg", 0.1, 0.5, 3), range("wind.velocity_m_s.0", -2.0, 2.0, 2)];
        Sweep { method, samples, seed: 3, min_success: 0.9, confident: false, ranges }
    }

    fn settings() -> Settings {
        let file = std::path::Path::new("unit.toml");
        super::super::file::read_text("", file, super::super::DEFAULTS, &[]).unwrap()
    }

    #[test]
    fn a_grid_has_every_combination_with_both_ends() {
        let samples = sweep(Method::Grid, None).samples(&settings());
        assert_eq!(
            samples,
            [[0.1, -2.0], [0.1, 2.0], [0.3, -2.0], [0.3, 2.0], [0.5, -2.0], [0.5, 2.0]]
        );
    }

    #[test]
    fn a_latin_hypercube_meets_every_stratum_of_every_range_once() {
        let sweep = sweep(Method::LatinHypercube, Some(50));
        let samples = sweep.samples(&settings());
        assert_eq!(samples.len(), 50);
        for (column, (from, to)) in [(0.1, 0.5), (-2.0, 2.0)].into_iter().enumerate() {
            let mut strata: Vec<usize> = samples
                .iter()
                .map(|sample| ((sample[column] - from) / (to - from) * 50.0) as usize)
                .collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..50).collect::<Vec<_>>(), "column {column}");
        }
        assert_eq!(samples, sweep.samples(&settings()), "the same samples whenever asked for");
        let other = Sweep { seed: 4, ..sweep };
        assert_ne!(samples, other.samples(&settings()));
    }

    #[test]
    fn whole_numbers_stay_whole() {
        let ranges = vec![range("seed", 1.0, 9.0, 4)];
        let sweep = Sweep { ranges, ..sweep(Method::Grid, None) };
        assert_eq!(sweep.samples(&settings()), [[1.0], [4.0], [6.0], [9.0]]);
    }

    #[test]
    fn a_sweep_that_cannot_fail_or_be_flown_is_refused_with_its_key() {
        let refused = |change: &dyn Fn(&mut Sweep)| {
            let mut sweep = sweep(Method::LatinHypercube, Some(5));
            change(&mut sweep);
            validate(&sweep, &settings()).unwrap_err().key
        };
        assert_eq!(refused(&|sweep| sweep.min_success = 0.0), "sweep.min_success");
        assert_eq!(refused(&|sweep| sweep.samples = None), "sweep.samples");
        assert_eq!(refused(&|sweep| sweep.ranges.clear()), "sweep.ranges");
        assert_eq!(refused(&|sweep| sweep.method = Method::Grid), "sweep.samples");
        assert_eq!(
            refused(&|sweep| sweep.ranges[1].key = "wind.kind".into()),
            "sweep.ranges.1.key"
        );
        assert_eq!(refused(&|sweep| sweep.ranges[0].to = Some(0.0)), "sweep.ranges.0.from");
    }
}
