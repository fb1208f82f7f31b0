//! The picture of a vehicle without a model: a plain quadrotor that does not pretend to be the real vehicle.

use twin_core::elementary::{cos, sin};
use twin_core::tick::Pose;
use twin_plant::model::Shape;
use twin_record::scene::{Scene, SceneBody, SceneGroup, SceneRotor, ShapeInfo};

/// Name of the only body.
const BODY: &str = "stand_in";

/// Colours of the frame, and of the arm that points forward.
const FRAME_RGBA: [f32; 4] = [0.55, 0.57, 0.60, 1.0];
const FRONT_RGBA: [f32; 4] = [0.84, 0.37, 0.0, 1.0];

/// Half of the distance between rotors along x and y, m, and their radius, m.
const REACH_M: f64 = 0.17;
const ROTOR_RADIUS_M: f64 = 0.12;

/// The scene of the stand-in.
pub fn stand_in() -> Scene {
    let rotor = |x: f64, y: f64, spin: i8| SceneRotor {
        position_in_body: [x * REACH_M, y * REACH_M, 0.03],
        radius_m: ROTOR_RADIUS_M,
        spin,
    };
    let rotors =
        vec![rotor(1.0, -1.0, 1), rotor(-1.0, 1.0, 1), rotor(1.0, 1.0, -1), rotor(-1.0, -1.0, -1)];
    let shape = |size_m: [f64; 3], position: [f64; 3], half_yaw: f64, rgba| ShapeInfo {
        shape: Shape::Box { size_m },
        position,
        quaternion_wxyz: [cos(half_yaw), 0.0, 0.0, sin(half_yaw)],
        rgba,
    };
    let beam = [4.0_f64.sqrt() * REACH_M * 2.0_f64.sqrt(), 0.025, 0.02];
    let eighth = std::f64::consts::FRAC_PI_8;
    let body = SceneBody {
        name: BODY.to_owned(),
        moving: true,
        pose: Pose { position: [0.0; 3], quaternion_wxyz: [1.0, 0.0, 0.0, 0.0] },
        group: SceneGroup::Vehicle,
        shapes: vec![
            shape([0.14, 0.10, 0.06], [0.0; 3], 0.0, FRAME_RGBA),
            shape(beam, [0.0; 3], eighth, FRAME_RGBA),
            shape(beam, [0.0; 3], -eighth, FRAME_RGBA),
            shape([0.05, 0.02, 0.02], [0.09, 0.0, 0.0], 0.0, FRONT_RGBA),
        ],
    };
    Scene { bodies: vec![body], rotors, base_body: BODY.to_owned() }
}
