//! Two lines through the last half minute: the path that the vehicle flew, and the reference path. They have every tenth tick only,
//! because each update sends the whole lines.

use std::collections::VecDeque;

use crate::server::protocol::ChannelInfo;
use crate::server::telemetry::Telemetry;

/// Path of the parent of both lines.
pub(super) const TRAILS: &str = "/twin/trails";

/// Path, stem of the channels `.x`, `.y`, `.z` in m, and colour of each line.
pub(super) const LINES: [(&str, &str, [u8; 3]); 2] = [
    ("/twin/trails/flown", "chi", [0xD5, 0x5E, 0x00]),
    ("/twin/trails/reference", "chi_des", [0x00, 0x9E, 0x73]),
];

/// Most points of a line.
const MOST_POINTS: usize = 300;

/// Ticks per point.
const EVERY: u64 = 10;

/// The least time between two updates of the lines, s. It is long because an update sends the whole lines.
const PERIOD_S: f64 = 0.5;

#[derive(Clone, Debug, Default)]
struct Line {
    /// Indices of x, y and z in a row; `None` if the flight has no such channels.
    places: Option<[usize; 3]>,
    /// Points, oldest first, m.
    points: VecDeque<[f32; 3]>,
}

/// The lines of one client, in the order of [`LINES`].
#[derive(Clone, Debug, Default)]
pub(super) struct Trails {
    lines: Vec<Line>,
    stale: bool,
    due_s: f64,
}

impl Trails {
    /// Lines without points, for rows with these channels.
    pub(super) fn new(channels: &[ChannelInfo]) -> Self {
        let place = |name: String| channels.iter().position(|info| info.name == name);
        let line = |stem: &str| {
            let places = ["x", "y", "z"].map(|axis| place(format!("{stem}.{axis}")));
            let [Some(x), Some(y), Some(z)] = places else { return Line::default() };
            Line { places: Some([x, y, z]), points: VecDeque::new() }
        };
        let lines = LINES.iter().map(|(_, stem, _)| line(stem)).collect();
        Self { lines, stale: false, due_s: f64::NEG_INFINITY }
    }

    /// Adds rows; a row with an unknown position gives no point.
    pub(super) fn extend(&mut self, telemetry: &Telemetry) {
        for (tick, row) in (telemetry.first_tick..).zip(&telemetry.rows) {
            if !tick.is_multiple_of(EVERY) {
                continue;
            }
            for line in &mut self.lines {
                let Some(places) = line.places else { continue };
                let point = places.map(|place| row.get(place).copied().unwrap_or(f32::NAN));
                if point.iter().all(|value| value.is_finite()) {
                    line.points.push_back(point);
                    self.stale = true;
                }
                if line.points.len() > MOST_POINTS {
                    line.points.pop_front();
                }
            }
        }
    }

    /// Path, colour and segments of each line if an update is due at `now_s`. A segment has two ends `[x y z]`, m.
    pub(super) fn due(&mut self, now_s: f64) -> Vec<(&'static str, [u8; 3], Vec<f32>)> {
        if !self.stale || now_s < self.due_s {
            return Vec::new();
        }
        (self.stale, self.due_s) = (false, now_s + PERIOD_S);
        let drawn = LINES
            .iter()
            .zip(&self.lines)
            .map(|((path, _, rgb), line)| (*path, *rgb, segments(line.points.iter().copied())));
        drawn.filter(|(_, _, ends)| !ends.is_empty()).collect()
    }
}

/// Both ends of the segments between successive points.
fn segments(points: impl Iterator<Item = [f32; 3]> + Clone) -> Vec<f32> {
    points.clone().zip(points.skip(1)).flat_map(|(a, b)| [a, b]).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::viewers::fixture;

    fn channels() -> Vec<ChannelInfo> {
        ["chi.x", "chi.y", "chi.z"].map(fixture::channel).into()
    }

    fn flown(ticks: std::ops::Range<u64>) -> Telemetry {
        fixture::flown(ticks, |tick| vec![tick as f32, 0.0, 1.0])
    }

    #[test]
    fn segments_join_every_tenth_tick_and_the_oldest_go() {
        let mut trails = Trails::new(&channels());
        trails.extend(&flown(5..31));
        // The flight has no channels for the second line.
        let wanted = [10.0, 0.0, 1.0, 20.0, 0.0, 1.0, 20.0, 0.0, 1.0, 30.0, 0.0, 1.0];
        assert_eq!(trails.due(0.0), [(LINES[0].0, LINES[0].2, wanted.to_vec())]);
        trails.extend(&flown(31..9000));
        let ends = &trails.due(10.0)[0].2;
        assert_eq!(ends.len(), (MOST_POINTS - 1) * 6);
        assert_eq!(ends[ends.len() - 3] as u64, 8990);
    }

    #[test]
    fn lines_are_sent_twice_a_second_at_most_and_only_if_there_is_more_of_them() {
        let mut trails = Trails::new(&channels());
        trails.extend(&flown(0..100));
        assert!(!trails.due(1.0).is_empty());
        assert!(trails.due(9.0).is_empty());
        trails.extend(&flown(100..200));
        assert!(!trails.due(9.0).is_empty());
        trails.extend(&flown(200..300));
        assert!(trails.due(9.4).is_empty() && !trails.due(9.5).is_empty());
    }

    #[test]
    fn a_place_that_is_unknown_gives_no_point() {
        let mut trails = Trails::new(&channels());
        let mut telemetry = flown(0..31);
        telemetry.rows[10] = std::sync::Arc::from([f32::NAN, 0.0, 1.0]);
        trails.extend(&telemetry);
        assert!(trails.due(0.0)[0].2.iter().all(|value| value.is_finite()));
    }
}
