//! Attitude marks along the flown path: the axes of the vehicle once per second of the last half minute, all in one message.

use std::collections::VecDeque;

use crate::server::protocol::ChannelInfo;
use crate::server::telemetry::Telemetry;
use twin_core::notation::Coords;
use twin_record::scene::base_pose;

/// Ticks per mark.
const EVERY: u64 = 100;

/// Most marks.
const MOST: usize = 30;

/// Channels of position (m) and attitude (rad).
const CHANNELS: [&str; 6] = ["chi.x", "chi.y", "chi.z", "chi.phi", "chi.theta", "chi.psi"];

/// The marks of one client.
#[derive(Clone, Debug, Default)]
pub(super) struct AttitudeMarks {
    places: Option<[usize; CHANNELS.len()]>,
    marks: VecDeque<[f32; 7]>,
    stale: bool,
}

impl AttitudeMarks {
    /// No marks, for rows with these channels.
    pub(super) fn new(channels: &[ChannelInfo]) -> Self {
        let found = CHANNELS.map(|name| channels.iter().position(|info| info.name == name));
        let places =
            found.iter().all(Option::is_some).then(|| found.map(Option::unwrap_or_default));
        Self { places, ..Self::default() }
    }

    /// Adds rows; a row with an unknown position or attitude gives no mark.
    pub(super) fn extend(&mut self, telemetry: &Telemetry) {
        let Some(places) = self.places else { return };
        for (tick, row) in (telemetry.first_tick..).zip(&telemetry.rows) {
            let values = places.map(|place| row.get(place).copied().unwrap_or(f32::NAN));
            if !tick.is_multiple_of(EVERY) || !values.iter().all(|value| value.is_finite()) {
                continue;
            }
            let mut chi = Coords::zeros();
            chi.iter_mut().zip(values).for_each(|(to, value)| *to = f64::from(value));
            let pose = base_pose(&chi);
            let ([x, y, z], [qw, qx, qy, qz]) = (pose.position, pose.quaternion_wxyz);
            if self.marks.len() == MOST {
                self.marks.pop_front();
            }
            self.marks.push_back([x, y, z, qw, qx, qy, qz].map(|value| value as f32));
            self.stale = true;
        }
    }

    /// All marks if there is a new one, as poses `[x y z w x y z]` in the world, m.
    pub(super) fn news(&mut self) -> Option<impl Iterator<Item = &[f32; 7]> + Clone> {
        std::mem::take(&mut self.stale).then(|| self.marks.iter())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::viewers::fixture::{channel, flown};

    #[test]
    fn each_second_leaves_a_mark_with_its_attitude_and_the_oldest_go() {
        let channels = CHANNELS.map(channel);
        let mut marks = AttitudeMarks::new(&channels);
        let quarter = std::f32::consts::FRAC_PI_2;
        // The vehicle is turned to the left by a quarter turn.
        let row = |tick: u64| vec![tick as f32, 0.0, 1.0, 0.0, 0.0, quarter];
        marks.extend(&flown(1..4001, row));
        let seen: Vec<[f32; 7]> = marks.news().expect("there are some").copied().collect();
        assert_eq!(seen.len(), MOST);
        assert_eq!([seen[0][0] as u64, seen[MOST - 1][0] as u64], [1100, 4000]);
        let half = std::f32::consts::FRAC_1_SQRT_2;
        for (found, wanted) in seen[0][3..].iter().zip([half, 0.0, 0.0, half]) {
            // The tolerance is two roundings of f32.
            assert!((found - wanted).abs() < 2.0 * f32::EPSILON, "{seen:?}");
        }
        assert!(marks.news().is_none());
        marks.extend(&flown(4001..4100, row));
        marks.extend(&flown(4100..4101, |_| vec![f32::NAN; 6]));
        assert!(marks.news().is_none());
    }
}
