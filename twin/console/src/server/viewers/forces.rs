//! Two arrows beside the vehicle: the measured residual force and the loop's estimate of it.

use crate::server::protocol::ChannelInfo;
use crate::server::telemetry::Telemetry;

/// Path of the parent of both arrows.
pub(super) const FORCES: &str = "/twin/forces";

/// Both arrows: path, stem of the channels `.x`, `.y`, `.z` in N, colour, and offset of the foot from the vehicle's root, m. The
/// arrows stand side by side, so that neither hides the other.
pub(super) const ARROWS: [(&str, &str, [u8; 3], [f32; 3]); 2] = [
    ("/twin/forces/residual", "residual", [0xD5, 0x5E, 0x00], [-0.06, 0.06, 0.0]),
    ("/twin/forces/estimate", "r_hat", [0x00, 0x72, 0xB2], [0.06, -0.06, 0.0]),
];

/// Scale of the arrows, as in the console, m/N.
const METRES_PER_NEWTON: f32 = 0.0125;

/// The least time between two updates of the arrows, s. It limits the load, because viser builds the arrows anew each time.
const PERIOD_S: f64 = 0.04;

/// Foot and tip of an arrow in the world, m.
pub(super) type Arrow = [[f32; 3]; 2];

/// The arrows of one client, in the order of [`ARROWS`].
#[derive(Clone, Debug, Default)]
pub(super) struct Forces {
    /// Indices in a row of the position and of each force; `None` if the flight has no such channels.
    places: Option<[[usize; 3]; 1 + ARROWS.len()]>,
    newest: Option<[Arrow; ARROWS.len()]>,
    due_s: f64,
}

impl Forces {
    /// Arrows for rows with these channels.
    pub(super) fn new(channels: &[ChannelInfo]) -> Self {
        let place = |name: String| channels.iter().position(|info| info.name == name);
        let three = |stem: &str| {
            let [x, y, z] = ["x", "y", "z"].map(|axis| place(format!("{stem}.{axis}")));
            Some([x?, y?, z?])
        };
        let [(_, residual, ..), (_, estimate, ..)] = ARROWS;
        let places = match [three("chi"), three(residual), three(estimate)] {
            [Some(at), Some(residual), Some(estimate)] => Some([at, residual, estimate]),
            _ => None,
        };
        Self { places, newest: None, due_s: f64::NEG_INFINITY }
    }

    /// Takes the newest row. If one of its numbers is unknown, both arrows stay as they are.
    pub(super) fn extend(&mut self, telemetry: &Telemetry) {
        let (Some(places), Some(row)) = (self.places, telemetry.rows.last()) else { return };
        let [at, forces @ ..] =
            places.map(|three| three.map(|place| row.get(place).copied().unwrap_or(f32::NAN)));
        let mut arrows = [[[0.0; 3]; 2]; ARROWS.len()];
        for ((arrow, force), (.., beside)) in arrows.iter_mut().zip(forces).zip(ARROWS) {
            let foot: [f32; 3] = std::array::from_fn(|k| at[k] + beside[k]);
            *arrow = [foot, std::array::from_fn(|k| foot[k] + METRES_PER_NEWTON * force[k])];
        }
        if arrows.as_flattened().as_flattened().iter().all(|value| value.is_finite()) {
            self.newest = Some(arrows);
        }
    }

    /// The arrows if they have changed and an update is due at `now_s`.
    pub(super) fn due(&mut self, now_s: f64) -> Option<[Arrow; ARROWS.len()]> {
        if now_s < self.due_s {
            return None;
        }
        let newest = self.newest.take()?;
        self.due_s = now_s + PERIOD_S;
        Some(newest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::viewers::fixture::{channel, flown};

    #[test]
    fn arrows_stand_beside_the_vehicle_are_as_long_as_the_force_and_come_25_times_a_second_at_most()
    {
        let stems = ["chi", "residual", "r_hat"];
        let names =
            stems.iter().flat_map(|stem| ["x", "y", "z"].map(|axis| format!("{stem}.{axis}")));
        let channels: Vec<ChannelInfo> = names.map(|name| channel(&name)).collect();
        let mut forces = Forces::new(&channels);
        assert_eq!(forces.due(0.0), None);
        forces.extend(&flown(0..3, |_| vec![1.0, 2.0, 3.0, 0.0, 0.0, 8.0, 16.0, 0.0, 0.0]));
        let [residual, estimate] = forces.due(0.0).expect("they are known");
        assert_eq!(residual, [[0.94, 2.06, 3.0], [0.94, 2.06, 3.0 + 0.1]]);
        assert_eq!(estimate, [[1.06, 1.94, 3.0], [1.06 + 0.2, 1.94, 3.0]]);
        assert_eq!(forces.due(1.0), None, "nothing new");
        forces.extend(&flown(3..4, |_| vec![0.0; 9]));
        assert_eq!(forces.due(0.03), None, "too soon");
        forces.extend(&flown(4..5, |_| vec![f32::NAN; 9]));
        let [[foot, _], _] = forces.due(0.05).expect("the last that were known");
        assert_eq!(foot.map(f32::to_bits), ARROWS[0].3.map(f32::to_bits));
        forces.extend(&flown(5..6, |_| vec![f32::NAN; 9]));
        assert_eq!(forces.due(9.0), None, "unknown");
        assert!(Forces::new(&channels[..6]).places.is_none());
    }
}
