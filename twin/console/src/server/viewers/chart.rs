//! Keeps the last half minute of a few channels for viser's charts. It keeps every tenth tick only, because viser needs the whole
//! curves at each update.

use std::collections::VecDeque;

use crate::server::protocol::ChannelInfo;
use crate::server::telemetry::Telemetry;
use twin_core::notation::TICK_S;

/// Most points of a curve.
const MOST_POINTS: usize = 300;

/// Ticks per point.
const EVERY: u64 = 10;

/// Times and values of some channels.
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    /// Indices of the channels in a row; `None` if the flight has no such channel.
    places: Vec<Option<usize>>,
    /// Time in s, then one value for each channel; oldest first.
    points: VecDeque<Vec<f64>>,
}

impl History {
    /// An empty history of the channels called `names`.
    pub(super) fn new(names: &[&str], channels: &[ChannelInfo]) -> Self {
        let place = |name: &&str| channels.iter().position(|info| info.name == **name);
        Self { places: names.iter().map(place).collect(), points: VecDeque::new() }
    }

    /// Adds rows; returns whether there are new points to draw.
    pub(super) fn extend(&mut self, telemetry: &Telemetry) -> bool {
        let mut new = false;
        for (tick, row) in (telemetry.first_tick..).zip(&telemetry.rows) {
            if !tick.is_multiple_of(EVERY) {
                continue;
            }
            let value = |place: &Option<usize>| {
                place.and_then(|place| row.get(place)).map_or(f64::NAN, |&value| f64::from(value))
            };
            let t_s = tick as f64 * TICK_S;
            self.points.push_back([t_s].into_iter().chain(self.places.iter().map(value)).collect());
            if self.points.len() > MOST_POINTS {
                self.points.pop_front();
            }
            new = true;
        }
        new
    }

    /// The columns of the chart: times in s, then the values of each channel. Before the first tick they have one time with unknown
    /// values, because the viewer computes the limits of its time axis from the first and the last time and fails without them.
    pub(super) fn columns(&self) -> Vec<Vec<f64>> {
        if self.points.is_empty() {
            return nothing_yet(self.places.len());
        }
        (0..=self.places.len())
            .map(|column| self.points.iter().map(|point| point[column]).collect())
            .collect()
    }
}

/// The columns of a chart with this number of channels before the first tick: one time, and NaN for each channel.
pub(super) fn nothing_yet(channels: usize) -> Vec<Vec<f64>> {
    [vec![0.0]].into_iter().chain(vec![vec![f64::NAN]; channels]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::viewers::fixture::{channel, flown};

    #[test]
    fn every_tenth_tick_is_kept_and_the_oldest_go() {
        let channels = [channel("a"), channel("b")];
        let mut history = History::new(&["b", "absent"], &channels);
        let start = history.columns();
        assert!(start.len() == 3 && start.iter().all(|column| column.len() == 1));
        assert!(start[0][0].abs() < 1e-12 && start[1][0].is_nan() && start[2][0].is_nan());
        let telemetry = flown(5..4000, |tick| vec![0.0, tick as f32]);
        assert!(history.extend(&telemetry));
        let columns = history.columns();
        assert_eq!(columns.len(), 3);
        assert!(columns.iter().all(|column| column.len() == MOST_POINTS));
        // The newest kept tick is 3990; the oldest lies 299 points of 10 ticks before it.
        assert!((columns[0][299] - 39.9).abs() < 1e-9 && (columns[0][0] - 10.0).abs() < 1e-9);
        assert_eq!(columns[1][299] as u64, 3990);
        assert!(columns[2].iter().all(|value| value.is_nan()));
        let between =
            Telemetry { first_tick: 4001, rows: telemetry.rows[..5].to_vec(), ..telemetry };
        assert!(!history.extend(&between));
    }
}
