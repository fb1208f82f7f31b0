//! Artificial ticks for unit tests: every field is set, and all numbers differ.

use nalgebra::{Vector2, Vector3};

use crate::elementary::sin;
use crate::foreseen::Foreseen;
use crate::notation::{Coords, TICK_S};
use crate::tick::{
    ActuatorCommand, Adaptation, Adapted, Contact, ControlState, Event, EventKind, Forecast,
    GripperCommand, GripperReading, InnerGains, InnerLaw, Measurement, Pose, Reference, Setpoint,
    Tick, Truth,
};

/// A number without a short decimal form, different for every `index` and `salt`.
pub fn number(index: u64, salt: u64) -> f64 {
    sin(index as f64 * 0.37 + salt as f64 * 1.3) / 3.0
}

fn coords(index: u64, salt: u64) -> Coords {
    Coords::from_fn(|row, _| number(index, salt + row as u64))
}

fn truth(index: u64) -> Truth {
    let pose = |salt| Pose {
        position: [number(index, salt), number(index, salt + 1), number(index, salt + 2)],
        quaternion_wxyz: [1.0, 0.0, 0.0, 0.0],
    };
    Truth {
        chi: coords(index, 1),
        chi_dot: coords(index, 11),
        poses: vec![pose(200), pose(300)],
        payload_position: Vector3::new(0.1, 0.2, number(index, 5)),
        payload_tilt_rad: 0.01,
        payload_speed_m_s: 0.02,
        payload_in_palm: Vector3::zeros(),
        grip_force_n: 20.5,
        collision_force_n: 0.0,
        wind_in_world: Vector3::zeros(),
        rotor_thrust_n: [7.25, 7.5, 7.75, 8.0, 0.0, 0.0, 0.0, 0.0],
        budget: None,
        contacts: vec![Contact {
            point_in_world: [1.0, 2.0, 3.0],
            force_in_world_n: [0.0, 0.0, number(index, 9)],
        }],
    }
}

fn setpoint(index: u64) -> Setpoint {
    let rows = InnerGains {
        law: InnerLaw::Rows,
        slope: coords(index, 60),
        damping: coords(index, 61),
        nominal_inertia: coords(index, 62),
        boundary_layer: 0.1,
    };
    Setpoint {
        force_in_world_n: Vector3::new(0.1, 0.2, 29.43),
        yaw_des: [0.0; 3],
        joint_des: Vector2::new(0.1, 0.2),
        joint_des_dot: Vector2::zeros(),
        joint_des_ddot: Vector2::zeros(),
        r_hat: coords(index, 63),
        sliding_norm: number(index, 64),
        robust_gain: number(index, 65),
        rows,
        gripper: GripperCommand::Close,
    }
}

fn adapted(index: u64) -> Adapted {
    Adapted {
        r_hat: coords(index, 40).into(),
        r_hat_prior: coords(index, 41).into(),
        innovation: coords(index, 42).into(),
        innovation_mean_norm: number(index, 43),
        covariance_trace: 32.0,
        covariance_max: 1.5,
        covariance_min: 0.5,
        gain_norm: 0.25,
        weight_norm: 0.75,
        bias: coords(index, 44),
        horizon: (0..6).map(|knot| coords(index, 45 + knot)).collect(),
        reset: index.is_multiple_of(7),
        frozen: false,
    }
}

fn foreseen(index: u64) -> Foreseen {
    Foreseen {
        lead_s: Coords::repeat(0.1),
        r_hat: coords(index, 70).into(),
        trust: Coords::repeat(0.75),
        used: coords(index, 71).into(),
        error: coords(index, 72).into(),
        std: coords(index, 73).into(),
        std_now: coords(index, 74).into(),
    }
}

/// A tick with every field set.
pub fn tick(index: u64) -> Tick {
    Tick {
        index,
        measurement: Measurement {
            t_s: (index + 1) as f64 * TICK_S,
            chi: coords(index, 1).into(),
            chi_dot: coords(index, 2).into(),
            chi_ddot: coords(index, 3).into(),
            tau_applied: coords(index, 4).into(),
            gripper: GripperReading { opening_m: 0.0625, speed_m_s: 0.0 },
            payload: None,
            saturated: index % 2 == 1,
            airborne: true,
        },
        truth: Some(truth(index)),
        reference: Reference {
            chi_des: coords(index, 20).into(),
            chi_des_dot: coords(index, 21).into(),
            chi_des_ddot: coords(index, 22),
            gripper: GripperCommand::Open,
            adaptation: Adaptation::Free,
            follows_measurement: false,
            transporting: true,
            cruising: false,
            release: None,
        },
        residual: coords(index, 30).into(),
        forecast: Forecast {
            base: vec![coords(index, 31).into(), coords(index, 32).into()],
            regime: vec![1.0, number(index, 33)],
            attention: Vec::new(),
        },
        adapted: adapted(index),
        foreseen: Some(foreseen(index)),
        control: ControlState {
            error: coords(index, 50).into(),
            sliding: coords(index, 51).into(),
            robust_gain: number(index, 52),
        },
        setpoint: setpoint(index),
        actuators: ActuatorCommand {
            rotor_thrust_n: [7.0; 8],
            joint_torque_n_m: Vector2::new(0.5, -0.25),
            saturated: false,
        },
        phase: "hover".to_owned(),
        events: if index.is_multiple_of(10) {
            vec![Event::new(EventKind::Phase, "entered hover")]
        } else {
            Vec::new()
        },
        fault: None,
        finished: false,
        gave_up: None,
    }
}
