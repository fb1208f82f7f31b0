//! Finds where two recorded flights diverge: the first tick and channel that differ, and the largest difference of every channel.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

use twin_core::tick::Tick;

/// The differences between two flights.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Number of ticks that both flights have.
    pub compared: usize,
    /// Number of ticks of each flight.
    pub ticks: [usize; 2],
    /// Number of ticks that are not equal.
    pub unequal: usize,
    /// The first difference.
    pub first: Option<FirstDifference>,
    /// The largest difference per channel, largest first. A different word (phase, event) counts as 1.
    pub channels: Vec<Channel>,
}

/// The first difference between two flights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FirstDifference {
    /// Index of the tick.
    pub tick: u64,
    /// Its time in the first flight, s.
    pub t_s: f64,
    /// The first channel that differs at this tick, in the order of the loop (measured before commanded).
    pub channel: String,
    /// The values of both flights.
    pub values: [String; 2],
}

/// The largest difference of one channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Channel {
    /// Dotted path of the channel in the tick.
    pub channel: String,
    /// Largest absolute difference.
    pub largest: f64,
    /// Time of that difference, s.
    pub at_s: f64,
    /// The values of both flights.
    pub values: [String; 2],
}

impl Difference {
    /// True if both flights have the same ticks to the last bit.
    pub fn none(&self) -> bool {
        self.unequal == 0 && self.ticks[0] == self.ticks[1]
    }
}

/// Compares two flights tick by tick.
pub fn diff(a: &[Tick], b: &[Tick]) -> Difference {
    let mut found = Difference {
        compared: a.len().min(b.len()),
        ticks: [a.len(), b.len()],
        ..Difference::default()
    };
    let mut channels: BTreeMap<String, Channel> = BTreeMap::new();
    for (left, right) in a.iter().zip(b) {
        if left == right {
            continue;
        }
        let mut differing = Vec::new();
        for (name, [left, right]) in stages(left, right) {
            walk(name.to_owned(), &left, &right, &mut differing);
        }
        // Two NaN are unequal as numbers, but do not count as a difference.
        if differing.is_empty() {
            continue;
        }
        found.unequal += 1;
        let t_s = left.measurement.t_s;
        if found.first.is_none() {
            found.first = differing.first().map(|(channel, _, values)| FirstDifference {
                tick: left.index,
                t_s,
                channel: channel.clone(),
                values: values.clone(),
            });
        }
        for (channel, largest, values) in differing {
            let new = Channel { channel: channel.clone(), largest, at_s: t_s, values };
            let known = channels.entry(channel).or_insert_with(|| new.clone());
            if new.largest > known.largest {
                *known = new;
            }
        }
    }
    found.channels = channels.into_values().collect();
    found.channels.sort_by(|x, y| y.largest.total_cmp(&x.largest));
    found
}

/// The parts of both ticks, in the order of the loop.
fn stages(a: &Tick, b: &Tick) -> Vec<(&'static str, [Value; 2])> {
    fn pair<T: Serialize>(a: &T, b: &T) -> [Value; 2] {
        [a, b].map(|part| serde_json::to_value(part).unwrap_or_default())
    }
    vec![
        ("measurement", pair(&a.measurement, &b.measurement)),
        ("reference", pair(&a.reference, &b.reference)),
        ("residual", pair(&a.residual, &b.residual)),
        ("forecast", pair(&a.forecast, &b.forecast)),
        ("adapted", pair(&a.adapted, &b.adapted)),
        ("control", pair(&a.control, &b.control)),
        ("setpoint", pair(&a.setpoint, &b.setpoint)),
        ("actuators", pair(&a.actuators, &b.actuators)),
        ("phase", pair(&a.phase, &b.phase)),
        ("events", pair(&a.events, &b.events)),
        ("fault", pair(&a.fault, &b.fault)),
        ("truth", pair(&a.truth, &b.truth)),
        ("finished", pair(&a.finished, &b.finished)),
        ("gave_up", pair(&a.gave_up, &b.gave_up)),
    ]
}

type Leaf = (String, f64, [String; 2]);

/// Collects the leaves that differ, with their paths.
fn walk(path: String, a: &Value, b: &Value, into: &mut Vec<Leaf>) {
    match (a, b) {
        (Value::Array(x), Value::Array(y)) if x.len() == y.len() => {
            for (index, (x, y)) in x.iter().zip(y).enumerate() {
                walk(format!("{path}.{index}"), x, y, into);
            }
        }
        (Value::Object(x), Value::Object(y)) => {
            for (key, x) in x {
                walk(format!("{path}.{key}"), x, y.get(key).unwrap_or(&Value::Null), into);
            }
        }
        _ if a == b => {}
        _ => {
            let size = match (a.as_f64(), b.as_f64()) {
                (Some(x), Some(y)) => (x - y).abs(),
                _ => 1.0,
            };
            into.push((path, size, [a.to_string(), b.to_string()]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_record::fixture;

    fn flight() -> Vec<Tick> {
        (0..50).map(fixture::tick).collect()
    }

    #[test]
    fn equal_flights_have_no_difference_and_a_shorter_one_has() {
        let found = diff(&flight(), &flight());
        assert!(found.none() && found.first.is_none() && found.channels.is_empty());
        assert!(!diff(&flight(), &flight()[..40]).none());
    }

    #[test]
    fn the_first_parting_is_named_and_the_largest_difference_stands_first() {
        let (a, mut b) = (flight(), flight());
        b[30].setpoint.r_hat[2] += 0.25;
        b[31].measurement.chi[0] += 1e-9;
        b[31].setpoint.r_hat[2] += 0.75;
        b[32].phase = "elsewhere".into();
        let found = diff(&a, &b);
        let first = found.first.clone().unwrap();
        assert_eq!((first.tick, first.channel.as_str()), (a[30].index, "setpoint.r_hat.2"));
        assert_eq!(found.unequal, 3);
        let names: Vec<&str> = found.channels.iter().map(|c| c.channel.as_str()).collect();
        assert_eq!(names, ["phase", "setpoint.r_hat.2", "measurement.chi.0"]);
        let r_hat = &found.channels[1];
        assert!((r_hat.largest - 0.75).abs() < 1e-12, "{r_hat:?}");
        assert!((r_hat.at_s - a[31].measurement.t_s).abs() < 1e-12);
    }
}
