//! Whether a change of a metric is better or worse, and the metrics of two flights side by side.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Metrics by name.
pub type Values = BTreeMap<String, f64>;

/// Beginnings of the names of metrics of which less is better.
const LESS: [&str; 12] = [
    "rms_error_",
    "position_rmse_",
    "residual_rmse_z",
    "saturation_share",
    "retries",
    "time_to_grasp_s",
    "innovation_mean_",
    "tilt_peak_rad",
    "grasp_slip_mm",
    "placement_",
    "resets",
    "faults",
];

/// Beginnings of the names of metrics of which more is better.
const MORE: [&str; 1] = ["residual_r2"];

/// Relative difference below which two values count as equal: the tables print four significant digits.
const EQUAL: f64 = 5e-5;

/// What a difference means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// The second flight is better.
    Better,
    /// The second flight is worse.
    Worse,
    /// The values are equal to four digits.
    Equal,
    /// Neither more nor less of it is better.
    Other,
    /// One of the flights does not have the metric.
    Missing,
}

impl Judgement {
    /// The word of a table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Worse => "worse",
            Self::Equal => "equal",
            Self::Other => "",
            Self::Missing => "in one only",
        }
    }
}

/// One metric of two flights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the metric, with its unit.
    pub metric: String,
    /// Value of the second flight; `None` if it has none.
    pub value: Option<f64>,
    /// Value of the first flight, its parent; `None` if it has none.
    pub parent: Option<f64>,
    /// `value - parent`, if both are known.
    pub difference: Option<f64>,
    /// Whether that is better.
    pub judgement: Judgement,
}

/// The metrics of `parent` and `other` side by side, by name.
pub fn side_by_side(parent: &Values, other: &Values) -> Vec<Row> {
    let added = other.keys().filter(|name| !parent.contains_key(*name));
    let mut names: Vec<&String> = parent.keys().chain(added).collect();
    names.sort();
    let row = |name: &String| {
        let [parent, value] =
            [parent, other].map(|of| of.get(name).copied().filter(|v| v.is_finite()));
        let difference = parent.zip(value).map(|(parent, value)| value - parent);
        let judgement = parent.zip(value).map_or(Judgement::Missing, |(p, v)| judge(name, p, v));
        Row { metric: name.clone(), value, parent, difference, judgement }
    };
    names.into_iter().map(row).collect()
}

fn judge(name: &str, parent: f64, value: f64) -> Judgement {
    let begins = |with: &[&str]| with.iter().any(|beginning| name.starts_with(beginning));
    let size = parent.abs().max(value.abs());
    match (begins(&LESS), begins(&MORE)) {
        _ if (value - parent).abs() <= EQUAL * size => Judgement::Equal,
        (true, _) if value < parent => Judgement::Better,
        (_, true) if value > parent => Judgement::Better,
        (false, false) => Judgement::Other,
        _ => Judgement::Worse,
    }
}

#[cfg(test)]
mod tests {
    use super::Judgement::{Better, Equal, Other, Worse};
    use super::*;

    fn values(of: &[(&str, f64)]) -> Values {
        of.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
    }

    #[test]
    fn less_error_is_better_more_explained_is_better_and_a_duration_is_neither() {
        let parent = values(&[("position_rmse_m", 0.1), ("residual_r2", 0.9), ("flight_s", 40.0)]);
        let other = values(&[("position_rmse_m", 0.05), ("residual_r2", 0.8), ("flight_s", 30.0)]);
        let judged = |parent, other| -> Vec<Judgement> {
            side_by_side(parent, other).into_iter().map(|row| row.judgement).collect()
        };
        assert_eq!(judged(&parent, &other), [Other, Better, Worse]);
        assert_eq!(judged(&other, &parent), [Other, Worse, Better]);
        assert_eq!(judged(&parent, &parent), [Equal, Equal, Equal]);
    }

    #[test]
    fn a_metric_of_one_flight_has_no_difference() {
        let (with, without) = (values(&[("time_to_grasp_s", 7.0)]), Values::new());
        for (parent, other) in [(&with, &without), (&without, &with)] {
            let rows = side_by_side(parent, other);
            assert_eq!((rows.len(), rows[0].difference), (1, None));
            assert_eq!(rows[0].judgement, Judgement::Missing);
        }
    }
}
