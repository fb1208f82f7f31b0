//! The task of a flight, from the settings of a scenario.

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};

use super::settings::{ExcitationSettings, PathSettings, PathShape, Settings, StartKind, TaskKind};
use twin_core::task::path::Curve;
use twin_core::task::{Excitation, FollowPath, Hover, PickPlace, PickPlacePlan, Region, Task};
use twin_core::tick::GripperCommand;
use twin_plant::model::Arm;

/// Joint angles of the arm, rad; zero for a joint that the vehicle does not have.
pub(super) fn joints(settings: &Settings, angles_rad: [f64; 2]) -> Vector2<f64> {
    Vector2::from_fn(
        |row, _| if row < settings.vehicle.arm_joints.len() { angles_rad[row] } else { 0.0 },
    )
}

fn curve(path: &PathSettings) -> Curve {
    match path.shape {
        PathShape::S => Curve::S {
            from: path.origin_m,
            length_m: path.length_m,
            sway_m: path.sway_m,
            rise_m: path.rise_m,
            bob_m: path.bob_m,
        },
        PathShape::FigureEight => Curve::FigureEight {
            centre: path.origin_m,
            a_m: path.half_length_m,
            b_m: path.half_width_m,
            laps: path.laps,
        },
    }
}

fn region(settings: &Settings) -> Region {
    let e: &ExcitationSettings = &settings.task.excitation;
    Region {
        position_m: [e.low_m.into(), e.high_m.into()],
        joints_rad: [joints(settings, e.joints_low_rad), joints(settings, e.joints_high_rad)],
        yaw_rad: e.yaw_rad,
        mean_speed_m_s: e.mean_speed_m_s,
        acceleration_m_s2: e.acceleration_m_s2,
    }
}

/// The task of a scenario.
pub(super) fn task(settings: &Settings, arm: Arm) -> Box<dyn Task> {
    let task = &settings.task;
    let position = Vector3::from(task.start_position_m);
    let transit_joints = joints(settings, task.transit_joints_rad);
    let grasp_joints = joints(settings, task.grasp_joints_rad);
    let gripper = match task.start {
        StartKind::Grasped => GripperCommand::Close,
        StartKind::Hover => GripperCommand::Open,
    };
    match task.kind {
        TaskKind::Hover => Box::new(Hover::new(position, grasp_joints, task.duration_s, gripper)),
        TaskKind::Excitation => Box::new(Excitation::new(
            (position, transit_joints),
            region(settings),
            task.duration_s,
            gripper,
            settings.seed,
        )),
        TaskKind::Path => Box::new(FollowPath::new(
            position,
            curve(&task.path),
            task.speed_m_s,
            transit_joints,
            gripper,
        )),
        TaskKind::PickPlace => {
            let mission = PickPlacePlan {
                start: position,
                path: curve(&task.path),
                speed_m_s: task.speed_m_s,
                place: Vector3::from(task.place_position_m),
                cube_size_m: settings.payload.size_m,
                least_payload_kg: task.least_payload_kg,
                opening_m: settings.vehicle.gripper.opening_m,
                grasp_joints,
                transit_joints,
                retry_limit: task.retry_limit,
            };
            Box::new(PickPlace::new(mission, Arc::new(arm)))
        }
    }
}
