//! A small scene for unit tests, beside the made-up ticks.

use crate::scene::{Scene, SceneBody, SceneGroup, SceneRotor, ShapeInfo};
use twin_core::tick::Pose;
use twin_plant::model::Shape;

pub use twin_core::fixture::tick;

/// One box that moves, one sphere that moves and one arena mesh that does not.
pub fn scene() -> Scene {
    let shape = |shape| ShapeInfo {
        shape,
        position: [0.0; 3],
        quaternion_wxyz: [1.0, 0.0, 0.0, 0.0],
        rgba: [0.5; 4],
    };
    let body = |name: &str, moving, group, form| SceneBody {
        name: name.to_owned(),
        moving,
        pose: Pose { position: [0.0; 3], quaternion_wxyz: [1.0, 0.0, 0.0, 0.0] },
        group,
        shapes: vec![shape(form)],
    };
    let mesh = Shape::Mesh {
        vertices: vec![[0.0; 3], [1.0; 3], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
    };
    Scene {
        bodies: vec![
            body("base_link", true, SceneGroup::Vehicle, Shape::Box { size_m: [0.3, 0.3, 0.1] }),
            body("floor", false, SceneGroup::Arena, mesh),
            body("cube", true, SceneGroup::Payload, Shape::Sphere { radius_m: 0.05 }),
        ],
        rotors: vec![SceneRotor { position_in_body: [0.23, 0.23, 0.05], radius_m: 0.15, spin: 1 }],
        base_body: "base_link".to_owned(),
    }
}
