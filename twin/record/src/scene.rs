//! The scene that a viewer draws: bodies with their shapes, once per flight. A tick then only moves the bodies.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

use twin_core::tick::{Pose, Tick};
use twin_plant::model::{Geometry, Shape};

/// Everything there is to draw.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, TS)]
pub struct Scene {
    /// Bodies; the moving ones are in the order of [`twin_core::tick::Truth::poses`].
    pub bodies: Vec<SceneBody>,
    /// Rotor discs of the vehicle, in rotor order.
    pub rotors: Vec<SceneRotor>,
    /// Name of the body that is the vehicle's root.
    pub base_body: String,
}

/// One body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
pub struct SceneBody {
    /// Unique name.
    pub name: String,
    /// Its pose changes from tick to tick.
    pub moving: bool,
    /// World pose at the start, and for good if it does not move, m.
    #[ts(as = "ScenePose")]
    pub pose: Pose,
    /// What the body belongs to.
    pub group: SceneGroup,
    /// Shapes in the body's frame.
    pub shapes: Vec<ShapeInfo>,
}

/// The form of a pose in the browser's protocol, m and `[w x y z]`.
#[derive(TS)]
#[expect(dead_code, reason = "describes `tick::Pose` to the generator of protocol.ts; never built")]
pub struct ScenePose {
    position: [f64; 3],
    quaternion_wxyz: [f64; 4],
}

/// What a body belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum SceneGroup {
    /// A link of the vehicle.
    Vehicle,
    /// Floor, box, table.
    Arena,
    /// What is carried.
    Payload,
}

/// One shape of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
pub struct ShapeInfo {
    /// Form and size.
    pub shape: Shape,
    /// Origin in the body's frame, m.
    pub position: [f64; 3],
    /// Body-from-shape quaternion, `[w x y z]`.
    pub quaternion_wxyz: [f64; 4],
    /// Colour and opacity, 0 to 1.
    pub rgba: [f32; 4],
}

/// One rotor disc.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, TS)]
pub struct SceneRotor {
    /// Hub in the frame of the vehicle's root, m.
    pub position_in_body: [f64; 3],
    /// Radius, m.
    pub radius_m: f64,
    /// 1: counter-clockwise seen from above, -1: clockwise.
    pub spin: i8,
}

impl From<&Geometry> for ShapeInfo {
    fn from(geometry: &Geometry) -> Self {
        let rotation = geometry.origin.rotation;
        Self {
            shape: geometry.shape.clone(),
            position: geometry.origin.translation.vector.into(),
            quaternion_wxyz: [rotation.w, rotation.i, rotation.j, rotation.k],
            rgba: geometry.rgba,
        }
    }
}

impl Scene {
    /// Bodies that move, in the order of the poses of a tick.
    pub fn moving(&self) -> impl Iterator<Item = &SceneBody> {
        self.bodies.iter().filter(|body| body.moving)
    }

    /// Poses of the moving bodies at `tick`: the true ones. Where the truth is unknown, the vehicle's root has its measured pose and all
    /// other bodies have `None`.
    pub fn poses_at(&self, tick: &Tick) -> Vec<Option<Pose>> {
        let known = tick.truth.as_ref().map(|truth| truth.poses.as_slice());
        self.moving()
            .enumerate()
            .map(|(index, body)| match known {
                Some(poses) => poses.get(index).copied(),
                None if body.name == self.base_body => Some(base_pose(&tick.measurement.chi)),
                None => None,
            })
            .collect()
    }
}

/// `world_from_body` of the vehicle's root at the coordinates `chi`, m.
pub fn base_pose(chi: &twin_core::notation::Coords) -> Pose {
    let rotation = nalgebra::UnitQuaternion::from_euler_angles(chi[3], chi[4], chi[5]);
    Pose {
        position: [chi[0], chi[1], chi[2]],
        quaternion_wxyz: [rotation.w, rotation.i, rotation.j, rotation.k],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::notation::{Coords, world_from_body};

    /// A quaternion and a matrix of the same angles differ by a few roundings.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn the_base_pose_turns_as_the_rotation_matrix_of_the_notation() {
        let chi = Coords::from([1.0, -2.0, 3.0, 0.2, -0.4, 2.5, 0.0, 0.0]);
        let pose = base_pose(&chi);
        let [w, x, y, z] = pose.quaternion_wxyz;
        let turned =
            nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        let oracle = world_from_body(&nalgebra::Vector3::new(0.2, -0.4, 2.5));
        assert!((turned.to_rotation_matrix().matrix() - oracle).norm() < ROUNDING);
        assert_eq!(pose.position.map(f64::to_bits), [1.0, -2.0, 3.0].map(f64::to_bits));
    }
}
