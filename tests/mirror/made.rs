//! Synthetic flights whose motion is known exactly: a vehicle of 1.5 kg on a circle, in the formats of PX4.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::LazyLock;

use crate::folder::Folder;
use mcap::records::MessageHeader;
use nalgebra::{UnitQuaternion, Vector3};
use twin_core::elementary::{cos, sin, squared};
use twin_foreign::gather::gather;
use twin_foreign::recorded::on_ticks;
use twin_foreign::shadow;
use twin_foreign::signals::{Signals, signals};
use twin_foreign::{Effort, Map, RecordedFlight, Survey};

/// Radius, m, and angular speed, rad/s, of the circle.
const RADIUS_M: f64 = 1.0;
const SPEED_RAD_S: f64 = 1.2;

/// Specific force per unit of thrust, m/s².
pub(crate) const GAIN: f64 = 20.0;

/// Offset of the recorder's clock from the flight controller's clock, µs.
const CLOCK_US: u64 = 1_700_000_000_000_000;

pub(crate) const ODOMETRY: &str = "uint64 timestamp\nuint64 timestamp_sample\nuint8 pose_frame\nfloat32[3] position\nfloat32[4] q\nuint8 velocity_frame\nfloat32[3] velocity\nfloat32[3] angular_velocity\n";
pub(crate) const THRUST: &str = "uint64 timestamp\nfloat32[3] xyz\n";

/// Writer of little-endian CDR, the format of ROS 2 messages.
pub(crate) struct Cdr(pub(crate) Vec<u8>);

impl Cdr {
    pub(crate) fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    pub(crate) fn put<const D: usize>(mut self, bytes: [u8; D]) -> Self {
        while !(self.0.len() - 4).is_multiple_of(D) {
            self.0.push(0);
        }
        self.0.extend(bytes);
        self
    }

    pub(crate) fn floats(self, values: &[f64]) -> Self {
        values.iter().fold(self, |cdr, v| cdr.put((*v as f32).to_le_bytes()))
    }
}

/// Properties of a synthetic file.
#[derive(Clone, Copy)]
pub(crate) struct Form {
    pub(crate) seconds: f64,
    pub(crate) compression: Option<mcap::Compression>,
    pub(crate) chunk_bytes: u64,
    /// Start and end of a gap without messages, s.
    pub(crate) hole_s: Option<(f64, f64)>,
}

pub(crate) const PLAIN: Form = Form {
    seconds: 20.0,
    compression: Some(mcap::Compression::Zstd),
    chunk_bytes: 16384,
    hole_s: None,
};

/// World (ENU) position, m, and acceleration, m/s², on the circle at a time.
pub(crate) fn truth(t_s: f64) -> (Vector3<f64>, Vector3<f64>) {
    let angle = SPEED_RAD_S * t_s;
    let position = Vector3::new(RADIUS_M * cos(angle), RADIUS_M * sin(angle), 1.5);
    let acceleration =
        Vector3::new(-cos(angle), -sin(angle), 0.0) * RADIUS_M * squared(SPEED_RAD_S);
    (position, acceleration)
}

/// The bytes of a synthetic flight as MCAP.
pub(crate) fn flight(form: Form) -> Vec<u8> {
    let mut writer = mcap::WriteOptions::new()
        .profile("ros2")
        .compression(form.compression)
        .compression_threads(0)
        .chunk_size(Some(form.chunk_bytes))
        .create(Cursor::new(Vec::new()))
        .expect("a writer");
    let mut channel = |topic: &str, schema: &str, text: &str| {
        let schema = writer.add_schema(schema, "ros2msg", text.as_bytes()).expect("a schema");
        writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).expect("a channel")
    };
    let odometry = channel("/fmu/out/vehicle_odometry", "px4_msgs/msg/VehicleOdometry", ODOMETRY);
    let thrust =
        channel("/fmu/out/vehicle_thrust_setpoint", "px4_msgs/msg/VehicleThrustSetpoint", THRUST);
    channel(
        "/fmu/out/vehicle_attitude",
        "px4_msgs/msg/VehicleAttitude",
        "uint64 timestamp\nuint64 timestamp_sample\nfloat32[4] q\n",
    );
    let messages = (form.seconds * 125.0) as u64;
    for i in 0..messages {
        let t_us = 1_000_000 + i * 8000;
        let t_s = i as f64 * 8e-3;
        if form.hole_s.is_some_and(|(from, to)| (from..to).contains(&t_s)) {
            continue;
        }
        let log_time = (t_us + CLOCK_US) * 1000;
        let mut write = |channel_id, data: Vec<u8>| {
            let header =
                MessageHeader { channel_id, sequence: i as u32, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, &data).expect("written");
        };
        // A quaternion and its negative are the same rotation; the sign alternates to test this.
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        let (message, specific_force) = odometry_message(t_us, t_s, sign);
        write(odometry, message);
        let u = specific_force / GAIN;
        write(thrust, Cdr::new().put(t_us.to_le_bytes()).floats(&[0.0, 0.0, -u]).0);
    }
    writer.finish().expect("finished");
    writer.into_inner().into_inner()
}

/// A ULog of PX4: half a second of attitude and thrust.
pub(crate) fn ulog() -> Vec<u8> {
    let message =
        |kind: u8, body: &[u8]| [&(body.len() as u16).to_le_bytes()[..], &[kind], body].concat();
    let mut bytes = [&b"ULog\x01\x12\x35\x01"[..], &[0; 8], &message(b'B', &[0; 40])].concat();
    bytes.extend(message(b'F', b"vehicle_thrust_setpoint:uint64_t timestamp;float[3] xyz;"));
    bytes.extend(message(b'A', b"\x00\x05\x00vehicle_thrust_setpoint"));
    for i in 0..25_u64 {
        let time = (1_000_000 + i * 20_000).to_le_bytes();
        let xyz = [0.0_f32, 0.0, -0.5].map(f32::to_le_bytes).concat();
        bytes.extend(message(b'D', &[&[5, 0][..], &time, &xyz].concat()));
    }
    bytes
}

/// Odometry and thrust on the circle; `t_us` is the time by the flight controller's clock, `t_s` the time of the flight.
pub(crate) fn messages(t_us: u64, t_s: f64) -> [Vec<u8>; 2] {
    let (odometry, specific_force) = odometry_message(t_us, t_s, 1.0);
    let thrust = Cdr::new().put(t_us.to_le_bytes()).floats(&[0.0, 0.0, -specific_force / GAIN]).0;
    [odometry, thrust]
}

/// The odometry message at a time, and the specific force in m/s².
fn odometry_message(t_us: u64, t_s: f64, sign: f64) -> (Vec<u8>, f64) {
    let (p, a) = truth(t_s);
    let force = a + Vector3::z() * 9.81;
    let enu = UnitQuaternion::rotation_between(&Vector3::z(), &force).expect("not opposite");
    // A second way from ENU to NED and from FLU to FRD: half turns about (1 1 0) and about x.
    let ned_from_enu = UnitQuaternion::from_axis_angle(
        &nalgebra::Unit::new_normalize(Vector3::new(1.0, 1.0, 0.0)),
        std::f64::consts::PI,
    );
    let flu_from_frd = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let q = (ned_from_enu * enu * flu_from_frd).into_inner() * sign;
    let position = ned_from_enu * p;
    let message = Cdr::new()
        .put(t_us.to_le_bytes())
        .put(t_us.to_le_bytes())
        .put([1])
        .floats(position.as_slice())
        .floats(&[q.w, q.i, q.j, q.k])
        .put([0])
        .floats(&[f64::NAN; 3])
        .floats(&[0.0; 3]);
    (message.0, force.norm())
}

/// Writes a file of this test run, whose folder no other process has.
pub(crate) fn file(name: &str, bytes: &[u8]) -> PathBuf {
    // A static is not dropped, so the folder stays: it is for reading after a failure.
    static FOLDER: LazyLock<Folder> = LazyLock::new(|| Folder::new("mirror"));
    let path = FOLDER.path(name);
    std::fs::write(&path, bytes).expect("a file");
    path
}

pub(crate) fn read(path: &std::path::Path, map: &Map) -> (Signals, RecordedFlight) {
    let signals = signals(&gather(path, map).expect("readable"));
    let recorded = on_ticks(&signals, &map.vehicle).expect("a pose");
    (signals, recorded)
}

fn generic() -> Map {
    Map::over_generic(Map::default()).expect("the generic map")
}

#[test]
fn a_flight_in_ned_and_frd_comes_out_where_it_was_flown_with_its_thrust_gain() {
    for (name, compression) in [
        ("zstd.mcap", Some(mcap::Compression::Zstd)),
        ("lz4.mcap", Some(mcap::Compression::Lz4)),
        ("none.mcap", None),
    ] {
        let path = file(name, &flight(Form { compression, ..PLAIN }));
        let (signals, recorded) = read(&path, &generic());
        for (tick, instant) in recorded.instants.iter().enumerate() {
            let (p, _) = truth(recorded.times_s[tick]);
            for row in 0..3 {
                // Tolerance: f32 at 1 m, and a cubic over 8 ms.
                assert!((instant.chi[row].expect("known") - p[row]).abs() < 1e-5, "{tick} {row}");
            }
        }
        let Effort::Fitted { fit, .. } = &recorded.effort else { panic!("{:?}", recorded.effort) };
        // Tolerance: `H` changes the circle's acceleration by 0.02 %; f32 and interpolation change it less.
        assert!((fit.gain / GAIN - 1.0).abs() < 1e-3, "{fit:?}");
        assert!(signals.attitude.as_ref().expect("it is there").sign_flips > 1000);
        // This file contains NaN and zeros as velocity and angular velocity: they are not measured, so the poses are differentiated.
        assert!(signals.velocity.is_none() && signals.body_rate.is_none());
        assert!(signals.notes.iter().any(|note| note.contains("BodyRate")), "{:?}", signals.notes);
        let base = signals.used[0].time;
        assert_eq!(base.offset_ns, CLOCK_US.cast_signed() * 1000);
    }
}

#[test]
fn the_residual_of_a_vehicle_that_obeys_physics_is_gravity_and_unknown_rows_are_not_zero() {
    let path = file("residual.mcap", &flight(PLAIN));
    let (_, recorded) = read(&path, &generic());
    let report = shadow(&recorded, None, &mut |_| {}).expect("ticks");
    for (row, wanted) in [(0, 0.0), (1, 0.0), (2, 9.81)] {
        let found = report.scored.rows[row].residual.expect("known");
        // Tolerance: the fit's 1e-3 of 10 m/s².
        assert!((found.mean - wanted).abs() < 0.02, "{row}: {found:?}");
    }
    for row in 3..8 {
        assert_eq!(report.scored.rows[row].residual, None, "{row}");
        assert_eq!(report.scored.rows[row].residual_known.to_bits(), 0.0_f64.to_bits());
    }
    let again = shadow(&recorded, None, &mut |_| {}).expect("ticks");
    assert_eq!(report, again);
}

#[test]
fn nothing_is_known_or_learned_inside_a_hole() {
    let hole = Form { hole_s: Some((6.0, 9.0)), ..PLAIN };
    let path = file("hole.mcap", &flight(hole));
    let (signals, recorded) = read(&path, &generic());
    assert_eq!(signals.used[0].timing.gaps, 1);
    let mut inside = 0;
    let report = shadow(&recorded, None, &mut |tick| {
        if (6.02..8.98).contains(&tick.measurement.t_s) {
            inside += 1;
            assert!(tick.adapted.frozen, "{}", tick.measurement.t_s);
            assert_eq!(tick.phase, "unknown");
        }
    })
    .expect("ticks");
    assert!(inside > 290 && report.held_ticks >= inside && report.fault_ticks == 0);
}

/// Asserts that a coordinate of the record is a number if `known` says so, and `null` otherwise.
fn assert_known(value: &serde_json::Value, known: impl Fn(usize) -> bool, name: &str) {
    for row in 0..8 {
        assert_eq!(value[row].is_number(), known(row), "{name} {row}: {value}");
        assert_eq!(value[row].is_null(), !known(row), "{name} {row}: {value}");
    }
}

#[test]
fn a_tick_says_no_number_that_the_recording_does_not_say() {
    // The oracle is the recording on its ticks, in which each value is a number or `None`.
    let path = file("known.mcap", &flight(Form { hole_s: Some((6.0, 9.0)), ..PLAIN }));
    let (_, mut recorded) = read(&path, &generic());
    // One rate is missing, and the vehicle stands on the ground for some time.
    recorded.instants[300].chi_dot[1] = None;
    recorded.airborne[400..450].fill(false);
    let mut ticks = Vec::new();
    shadow(&recorded, None, &mut |tick| ticks.push(serde_json::to_value(tick).expect("JSON")));
    assert_eq!(ticks.len(), recorded.instants.len());
    for (index, (tick, said)) in ticks.iter().zip(&recorded.instants).enumerate() {
        let measurement = &tick["measurement"];
        for (field, rows) in [
            ("chi", &said.chi),
            ("chi_dot", &said.chi_dot),
            ("chi_ddot", &said.chi_ddot),
            ("tau_applied", &said.tau),
        ] {
            assert_known(
                &measurement[field],
                |row| rows[row].is_some(),
                &format!("{index} {field}"),
            );
        }
        let residual = |row: usize| recorded.residual_counts(index, row);
        assert_known(&tick["residual"], residual, &format!("{index} residual"));
        for estimate in ["r_hat", "r_hat_prior", "innovation"] {
            assert_known(&tick["adapted"][estimate], residual, &format!("{index} {estimate}"));
        }
        for base in tick["forecast"]["base"].as_array().expect("a horizon") {
            assert_known(base, residual, &format!("{index} base"));
        }
        let moved = |row: usize| said.chi[row].is_some();
        assert_known(&tick["control"]["error"], moved, &format!("{index} error"));
        assert_known(&tick["reference"]["chi_des"], moved, &format!("{index} expected"));
    }
}

#[test]
fn a_survey_counts_what_was_written_and_names_the_empty_channel() {
    let path = file("survey.mcap", &flight(PLAIN));
    let survey = Survey::read(&path).expect("readable");
    assert!(survey.container.complete && survey.container.problems.is_empty());
    assert_eq!(survey.messages, 5000);
    let counts: Vec<u64> = survey.channels.iter().map(|info| info.messages).collect();
    assert_eq!(counts, [0, 2500, 2500]);
    assert!((survey.channels[1].rate_hz - 125.0).abs() < 1e-6);
}
