//! Made flights that rotate under known torques: a vehicle in closed loop, in the form that PX4 writes, in NED and FRD.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use twin_core::elementary::{cos, powi};
use twin_foreign::shadow;
use twin_foreign::{Effort, Map, RecordedFlight, Torque, TorqueAxis, TorqueFit};

use super::made::{Cdr, GAIN, ODOMETRY, THRUST, file, read};

/// Angular acceleration per unit of torque about forward, right, down, rad/s².
const GAINS: [f64; 3] = [200.0, 150.0, 60.0];

/// Principal moments of inertia, kg m². They differ, so there is a gyroscopic torque.
const INERTIA: [f64; 3] = [0.02, 0.03, 0.05];

/// Constant roll acceleration besides the torques, rad/s².
const TRIM: f64 = -2.0;

const LAG_MS: usize = 30;
const SECONDS: usize = 50;

const RATE_GAIN: [f64; 3] = [0.05, 0.06, 0.1];
const ATTITUDE_GAIN: f64 = 4.0;

const TORQUE: &str = THRUST;
const WANTED: &str = "uint64 timestamp\nfloat32[4] q_d\n";

/// A pseudo-random number between -1 and 1 that is independent of its neighbours.
fn noise(ms: usize, salt: u64) -> f64 {
    let mut x =
        (ms as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ salt.wrapping_mul(0xD1B5_4A32_D192_ED03);
    for _ in 0..2 {
        x = (x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    }
    (x >> 11) as f64 / powi(2.0_f64, 52) - 1.0
}

/// Roll, pitch, yaw of `ned_from_frd`.
fn angles(attitude: &Rotation3<f64>) -> Vector3<f64> {
    let (roll, pitch, yaw) = attitude.euler_angles();
    Vector3::new(roll, pitch, yaw)
}

/// State of the vehicle.
struct State {
    attitude: Rotation3<f64>,
    rate: Vector3<f64>,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    gust: Vector3<f64>,
    wanted: Vector3<f64>,
    sent: Vec<Vector3<f64>>,
}

impl State {
    /// Advances by one millisecond; returns the commanded torque and thrust.
    fn step(&mut self, ms: usize, step_rad: f64) -> (Vector3<f64>, f64) {
        let inertia = Vector3::from(INERTIA);
        if ms.is_multiple_of(1987) {
            self.wanted = Vector3::from_fn(|axis, _| step_rad * noise(ms, axis as u64));
        }
        let now = angles(&self.attitude);
        let random =
            |salt, size: f64| Vector3::from_fn(|axis, _| size * noise(ms, salt + axis as u64));
        self.gust += -self.gust * 0.012 + random(10, 0.4);
        let rate = self.rate + random(20, 0.02);
        let torque =
            ((self.wanted - now) * ATTITUDE_GAIN - rate).component_mul(&Vector3::from(RATE_GAIN));
        self.sent.push(torque);
        let acts = self.sent[ms.saturating_sub(LAG_MS)].component_mul(&Vector3::from(GAINS));
        let gyroscopic =
            self.rate.cross(&inertia.component_mul(&self.rate)).component_div(&inertia);
        self.rate += (acts + self.gust + Vector3::x() * TRIM - gyroscopic) * 1e-3;
        let thrust = 9.81 / (GAIN * cos(now.x) * cos(now.y));
        self.velocity +=
            (self.attitude * Vector3::z() * (-GAIN * thrust) + Vector3::z() * 9.81) * 1e-3;
        self.position += self.velocity * 1e-3;
        self.attitude *= Rotation3::new(self.rate * 1e-3);
        (torque, thrust)
    }
}

/// The bytes of a flight whose attitude set-point has steps of `step_rad`; `wanted` says whether the set-point is logged.
fn flight(step_rad: f64, wanted: bool) -> Vec<u8> {
    let mut writer = mcap::WriteOptions::new()
        .profile("ros2")
        .compression_threads(0)
        .create(Cursor::new(Vec::new()))
        .expect("a writer");
    let mut channel = |topic: &str, kind: &str, text: &str| {
        let name = format!("px4_msgs/msg/{kind}");
        let schema = writer.add_schema(&name, "ros2msg", text.as_bytes()).expect("a schema");
        let topic = format!("/fmu/out/{topic}");
        writer.add_channel(schema, &topic, "cdr", &BTreeMap::new()).expect("a channel")
    };
    let odometry = channel("vehicle_odometry", "VehicleOdometry", ODOMETRY);
    let thrust = channel("vehicle_thrust_setpoint", "VehicleThrustSetpoint", THRUST);
    let torque = channel("vehicle_torque_setpoint", "VehicleTorqueSetpoint", TORQUE);
    let setpoint = channel("vehicle_attitude_setpoint", "VehicleAttitudeSetpoint", WANTED);
    let zero = Vector3::zeros;
    let mut state = State {
        attitude: Rotation3::identity(),
        rate: zero(),
        position: Vector3::new(1.0, 2.0, -3.0),
        velocity: zero(),
        gust: zero(),
        wanted: zero(),
        sent: Vec::new(),
    };
    for ms in 0..SECONDS * 1000 {
        let (asked, u) = state.step(ms, step_rad);
        let t_us = 1_000_000 + ms as u64 * 1000;
        let mut write = |channel_id, message: Cdr| {
            let log_time = t_us * 1000;
            let header =
                MessageHeader { channel_id, sequence: ms as u32, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, &message.0).expect("written");
        };
        let stamped = || Cdr::new().put(t_us.to_le_bytes());
        if ms % 8 == 0 {
            let q = UnitQuaternion::from_rotation_matrix(&state.attitude);
            let measured = state.rate + Vector3::from_fn(|i, _| 0.01 * noise(ms, 30 + i as u64));
            let message = stamped().put(t_us.to_le_bytes()).put([1]);
            let pose = message.floats(state.position.as_slice()).floats(&[q.w, q.i, q.j, q.k]);
            write(odometry, pose.put([0]).floats(&[f64::NAN; 3]).floats(measured.as_slice()));
        }
        if ms % 20 == 0 {
            write(thrust, stamped().floats(&[0.0, 0.0, -u]));
            let folded = asked + Vector3::from_fn(|i, _| 0.004 * noise(ms, 40 + i as u64));
            write(torque, stamped().floats(folded.as_slice()));
        }
        if wanted && ms % 50 == 0 {
            let [roll, pitch, yaw] = state.wanted.into();
            let q = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
            write(setpoint, stamped().floats(&[q.w, q.i, q.j, q.k]));
        }
    }
    writer.finish().expect("finished");
    writer.into_inner().into_inner()
}

fn torque(recorded: &RecordedFlight) -> &Torque {
    match &recorded.effort {
        Effort::Fitted { torque, .. } => torque,
        other => panic!("{other:?}"),
    }
}

fn gains(torque: &Torque) -> Vec<TorqueFit> {
    let gain = |axis: &TorqueAxis| match axis {
        TorqueAxis::Fitted(fit) => *fit,
        TorqueAxis::Unknown { why } => panic!("{why}"),
    };
    torque.axes.iter().map(gain).collect()
}

fn generic(vehicle: &str) -> Map {
    Map::over_generic(Map::parse(vehicle, "test").expect("a map")).expect("the generic map")
}

#[test]
fn a_flight_that_turns_gives_its_torque_gains_and_the_rows_of_the_attitude_are_known() {
    let path = file("turned.mcap", &flight(0.2, true));
    let (signals, recorded) = read(&path, &generic(""));
    assert!(signals.body_rate.is_some() && signals.attitude_setpoint.is_some());
    let torque = torque(&recorded);
    assert!(torque.per_inertia);
    for (fit, wanted) in gains(torque).iter().zip(GAINS) {
        // Three standard errors: one flight in four hundred is further off.
        assert!((fit.gain - wanted).abs() < 3.0 * fit.standard_error, "{wanted}: {fit:?}");
        assert!(fit.standard_error < 0.15 * fit.gain, "{wanted}: {fit:?}");
    }
    let report = shadow(&recorded, None, &mut |_| {}).expect("ticks");
    for row in 3..6 {
        assert!(report.scored.rows[row].residual_known > 0.9, "{row}");
    }
    // The residual is the commanded torque that balances the trim. The bound covers the error of the gain and
    // the mean of the gusts.
    let roll = report.scored.rows[3].residual.expect("known");
    assert!((roll.mean + TRIM).abs() < 0.5, "{roll:?}");
    // With a known inertia the same flight has torques in N m, here smaller by a factor of 50.
    let known = generic("[vehicle]\ninertia_kg_m2 = [0.02, 0.03, 0.05]\n");
    let (_, heavy) = read(&path, &known);
    let report = shadow(&heavy, known.vehicle.inertia_kg_m2, &mut |_| {}).expect("ticks");
    let n_m = report.scored.rows[3].residual.expect("known");
    assert!((n_m.mean + TRIM * INERTIA[0]).abs() < 0.5 * INERTIA[0], "{n_m:?}");
}

#[test]
fn a_hover_without_excitation_and_a_log_without_set_points_leave_the_rows_unknown() {
    for (name, bytes, reason) in [
        ("turned_hover.mcap", flight(0.0, true), "too little excitation"),
        ("turned_unwanted.mcap", flight(0.2, false), "no attitude set-point in the log"),
    ] {
        let (_, recorded) = read(&file(name, &bytes), &generic(""));
        for axis in &torque(&recorded).axes {
            let TorqueAxis::Unknown { why } = axis else { panic!("{axis:?}") };
            assert!(why.contains(reason), "{why}");
        }
        let report = shadow(&recorded, None, &mut |_| {}).expect("ticks");
        assert!(report.scored.rows[2].residual.is_some());
        assert!(report.scored.rows[3..6].iter().all(|row| row.residual.is_none()), "{name}");
    }
}
