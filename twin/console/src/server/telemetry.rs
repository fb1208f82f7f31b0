//! The binary telemetry frame, version 2: a 44-byte header, rows, poses, contacts, spectrum; little-endian.
//!
//! ```text
//!  0 u8 0xC1 | 1 u8 version | 2 u16 schema_id | 4 u32 first_tick | 8 u16 rows | 10 u16 n_channels | 12 u16 n_bodies
//! 14 u16 n_contacts | 16 u32 gap | 20 u32 flags (bit 0: reset) | 24 f64 t_sim, s | 32 f64 t_wall, s
//! 40 u16 n_spectrum | 42 u16 0
//! 44 rows x n_channels f32, n_bodies x 7 f32 (x y z, w x y z), ghost 7 f32, n_contacts x 6 f32 (point m, force N),
//!    n_spectrum f32 (eigenvalues of the adapter's covariance, largest first)
//! ```

use std::sync::Arc;

use crate::server::protocol::PROTOCOL_VERSION;
use twin_core::notation::KnownCoords;
use twin_core::tick::{Pose, Tick};
use twin_record::scene::{Scene, base_pose};

/// First byte of a frame: the one byte that `MessagePack` never uses.
pub const MAGIC: u8 = 0xC1;

/// Bytes before the first row.
pub const HEADER_BYTES: usize = 44;

/// Largest number of contacts in a frame.
const MOST_CONTACTS: usize = 256;

/// The picture of a tick; a frame contains that of its newest tick only.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Simulated time, s.
    pub t_s: f64,
    /// Poses of the moving bodies in scene order; NaN where unknown.
    pub poses: Vec<[f32; 7]>,
    /// Pose of the vehicle's root on the reference.
    pub ghost: [f32; 7],
    /// Contact points in m and their forces in N, in the world.
    pub contacts: Vec<[f32; 6]>,
    /// Eigenvalues of the adapter's covariance, largest first.
    pub spectrum: Vec<f32>,
}

impl Picture {
    /// The picture of `tick`, with the eigenvalues of the adapter's covariance. The vehicle is left out if its position or attitude is
    /// unknown.
    pub fn new(scene: &Scene, tick: &Tick, spectrum: &[f64]) -> Self {
        let is_placed = |chi: &KnownCoords| chi.known()[..6] == [true; 6];
        let is_seen = tick.truth.is_some() || is_placed(&tick.measurement.chi);
        let ghost = is_seen && is_placed(&tick.reference.chi_des);
        let contacts = tick.truth.as_ref().map_or(&[][..], |truth| &truth.contacts);
        Self {
            t_s: tick.measurement.t_s,
            poses: scene
                .poses_at(tick)
                .iter()
                .map(|pose| pose.as_ref().filter(|_| is_seen).map_or([f32::NAN; 7], seven))
                .collect(),
            ghost: if ghost { seven(&base_pose(&tick.reference.chi_des)) } else { [f32::NAN; 7] },
            contacts: contacts
                .iter()
                .take(MOST_CONTACTS)
                .map(|contact| {
                    let ([x, y, z], [fx, fy, fz]) =
                        (contact.point_in_world, contact.force_in_world_n);
                    [x, y, z, fx, fy, fz].map(|value| value as f32)
                })
                .collect(),
            spectrum: spectrum.iter().map(|value| *value as f32).collect(),
        }
    }
}

/// Rows of consecutive ticks with the newest picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Telemetry {
    /// Schema of the rows, given by a `hello`.
    pub schema_id: u16,
    /// Tick of the first row.
    pub first_tick: u64,
    /// One row per tick.
    pub rows: Vec<Arc<[f32]>>,
    /// Number of ticks just before the first row that this client missed.
    pub gap: u32,
    /// True in the first frame after a restart.
    pub reset: bool,
    /// Newest picture.
    pub picture: Arc<Picture>,
}

impl Telemetry {
    /// Keeps the first `rows` rows and returns the others, which follow them without a gap.
    pub(super) fn split_off(&mut self, rows: usize) -> Self {
        Self {
            first_tick: self.first_tick + rows as u64,
            rows: self.rows.split_off(rows),
            gap: 0,
            reset: false,
            schema_id: self.schema_id,
            picture: Arc::clone(&self.picture),
        }
    }

    /// The bytes on the wire; `t_wall_s` is the time since the server started.
    pub fn encode(&self, t_wall_s: f64) -> Vec<u8> {
        let channels = self.rows.first().map_or(0, |row| row.len());
        let Picture { t_s, poses, ghost, contacts, spectrum } = &*self.picture;
        let drawn_floats = (poses.len() + 1) * 7 + contacts.len() * 6 + spectrum.len();
        let floats = self.rows.len() * channels + drawn_floats;
        let mut bytes = Vec::with_capacity(HEADER_BYTES + 4 * floats);
        bytes.extend([MAGIC, PROTOCOL_VERSION]);
        bytes.extend(self.schema_id.to_le_bytes());
        bytes.extend((self.first_tick as u32).to_le_bytes());
        for count in [self.rows.len(), channels, poses.len(), contacts.len()] {
            bytes.extend((count as u16).to_le_bytes());
        }
        bytes.extend(self.gap.to_le_bytes());
        bytes.extend(u32::from(self.reset).to_le_bytes());
        bytes.extend(t_s.to_le_bytes());
        bytes.extend(t_wall_s.to_le_bytes());
        bytes.extend((spectrum.len() as u16).to_le_bytes());
        bytes.extend([0, 0]);
        let rows = self.rows.iter().flat_map(|row| row.iter());
        let drawn =
            poses.iter().flatten().chain(ghost).chain(contacts.iter().flatten()).chain(spectrum);
        for value in rows.chain(drawn) {
            bytes.extend(value.to_le_bytes());
        }
        bytes
    }
}

fn seven(pose: &Pose) -> [f32; 7] {
    let ([x, y, z], [qw, qx, qy, qz]) = (pose.position, pose.quaternion_wxyz);
    [x, y, z, qw, qx, qy, qz].map(|value| value as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_record::fixture;

    #[test]
    fn a_frame_is_what_the_protocol_says_byte_by_byte() {
        let picture = Picture {
            t_s: 0.125,
            poses: vec![[1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0]],
            ghost: [4.0, 5.0, 6.0, 0.0, 1.0, 0.0, 0.0],
            contacts: vec![[7.0, 8.0, 9.0, 0.5, 0.25, -1.0]],
            spectrum: vec![3.5, 0.125],
        };
        let telemetry = Telemetry {
            schema_id: 0x0201,
            first_tick: 0x0403_0201,
            rows: vec![[10.0_f32, 11.0].into(), [12.0_f32, f32::NAN].into()],
            gap: 5,
            reset: true,
            picture: Arc::new(picture),
        };
        let bytes = telemetry.encode(2.0);
        #[rustfmt::skip]
        let header = [
            0xC1, 2, 1, 2, 1, 2, 3, 4, 2, 0, 2, 0, 1, 0, 1, 0, 5, 0, 0, 0, 1, 0, 0, 0,
            0, 0, 0, 0, 0, 0, 0xC0, 0x3F, // 0.125
            0, 0, 0, 0, 0, 0, 0, 0x40, // 2.0
            2, 0, 0, 0,
        ];
        assert_eq!(bytes[..HEADER_BYTES], header);
        let floats: Vec<f32> = bytes[HEADER_BYTES..]
            .chunks(4)
            .map(|four| f32::from_le_bytes(four.try_into().expect("four bytes")))
            .collect();
        assert_eq!(floats.len(), 2 * 2 + 7 + 7 + 6 + 2);
        assert_eq!(floats[..3], [10.0, 11.0, 12.0]);
        assert!(floats[3].is_nan());
        assert_eq!(floats[4..11], [1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0]);
        assert_eq!(floats[11..18], [4.0, 5.0, 6.0, 0.0, 1.0, 0.0, 0.0]);
        assert_eq!(floats[18..24], [7.0, 8.0, 9.0, 0.5, 0.25, -1.0]);
        assert_eq!(floats[24..], [3.5, 0.125]);
    }

    #[test]
    fn a_picture_has_the_moving_bodies_in_scene_order_and_nothing_unknown_is_made_up() {
        let scene = fixture::scene();
        let mut tick = fixture::tick(4);
        let picture = Picture::new(&scene, &tick, &[]);
        let truth = tick.truth.take().unwrap();
        assert_eq!(picture.poses.len(), 2);
        assert_eq!(picture.poses[1][0].to_bits(), (truth.poses[1].position[0] as f32).to_bits());
        let blind = Picture::new(&scene, &tick, &[]);
        assert_eq!(blind.poses[0][2].to_bits(), (tick.measurement.chi[2] as f32).to_bits());
        assert!(blind.poses[1].iter().all(|value| value.is_nan()) && blind.contacts.is_empty());
    }
}
