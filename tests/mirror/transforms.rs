//! A made flight as transforms and poses of ROS 2 and Foxglove. Encoders of other programs write it, and every form gives the same
//! flight.

use std::collections::BTreeMap;
use std::io::Cursor;

use foxglove::Encode;
use foxglove::messages as fox;
use mcap::records::MessageHeader;
use nalgebra::{UnitQuaternion, Vector3};
use twin_foreign::Map;

use super::made::{Cdr, file, read, truth};

/// Definitions as ROS 2 embeds them.
const HEADER: &str = "===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
const QUATERNION: &str =
    "===\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";
const STAMPED: &str =
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n";
const TRANSFORM: &str = "===\nMSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n===\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
const POSE: &str = "std_msgs/Header header\ngeometry_msgs/Pose pose\n===\nMSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n===\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n";

/// Time by which the vehicle's clock is behind that of the recorder, ns: the stamp of a message is earlier than its log time.
const LATE_NS: u64 = 5_000_000;

/// Yaw of the vehicle over time, rad.
fn yaw(t_s: f64) -> f64 {
    0.3 * t_s
}

/// Appends a string in CDR: its length with the terminating zero, its characters, zero.
fn text(cdr: Cdr, text: &str) -> Cdr {
    let sized = cdr.put((text.len() as u32 + 1).to_le_bytes());
    text.bytes().chain([0]).fold(sized, |cdr, byte| cdr.put([byte]))
}

fn header(cdr: Cdr, ns: u64) -> Cdr {
    let sec = (ns / 1_000_000_000) as i32;
    let nanosec = (ns % 1_000_000_000) as u32;
    text(cdr.put(sec.to_le_bytes()).put(nanosec.to_le_bytes()), "world")
}

/// Appends position and quaternion x y z w.
fn pose(cdr: Cdr, p: &Vector3<f64>, q: &UnitQuaternion<f64>) -> Cdr {
    let numbers = [p.x, p.y, p.z, q.i, q.j, q.k, q.w];
    numbers.iter().fold(cdr, |cdr, number| cdr.put(number.to_le_bytes()))
}

/// Appends a stamped transform of ROS 2 for the frame `child`.
fn transform(cdr: Cdr, ns: u64, child: &str, p: &Vector3<f64>, q: &UnitQuaternion<f64>) -> Cdr {
    pose(text(header(cdr, ns), child), p, q)
}

fn stamp(ns: u64) -> fox::Timestamp {
    fox::Timestamp::new((ns / 1_000_000_000) as u32, (ns % 1_000_000_000) as u32)
}

fn fox_quaternion(q: &UnitQuaternion<f64>) -> fox::Quaternion {
    fox::Quaternion { x: q.i, y: q.j, z: q.k, w: q.w }
}

fn fox_transform(
    ns: u64,
    child: &str,
    p: &Vector3<f64>,
    q: &UnitQuaternion<f64>,
) -> fox::FrameTransform {
    fox::FrameTransform {
        timestamp: Some(stamp(ns)),
        parent_frame_id: "world".to_owned(),
        child_frame_id: child.to_owned(),
        translation: Some(fox::Vector3 { x: p.x, y: p.y, z: p.z }),
        rotation: Some(fox_quaternion(q)),
    }
}

fn encoded(message: &impl Encode) -> Vec<u8> {
    let mut bytes = Vec::new();
    message.encode(&mut bytes).expect("encoded");
    bytes
}

/// Name, encodings, schema, and the function that encodes a time in ns and a pose.
struct Form {
    schema: (String, String, Vec<u8>),
    encoding: &'static str,
    message: fn(u64, &Vector3<f64>, &UnitQuaternion<f64>) -> Vec<u8>,
}

fn ros(
    name: &str,
    definition: String,
    message: fn(u64, &Vector3<f64>, &UnitQuaternion<f64>) -> Vec<u8>,
) -> Form {
    let schema = (name.to_owned(), "ros2msg".to_owned(), definition.into_bytes());
    Form { schema, encoding: "cdr", message }
}

fn foxglove<M: Encode>(message: fn(u64, &Vector3<f64>, &UnitQuaternion<f64>) -> Vec<u8>) -> Form {
    let schema = M::get_schema().expect("a schema");
    let schema = (schema.name, schema.encoding, schema.data.into_owned());
    Form { schema, encoding: "protobuf", message }
}

/// Position of a frame of another object.
fn elsewhere() -> Vector3<f64> {
    Vector3::new(9.0, 9.0, 9.0)
}

fn forms() -> Vec<Form> {
    vec![
        ros(
            "tf2_msgs/msg/TFMessage",
            format!(
                "geometry_msgs/TransformStamped[] transforms\n===\nMSG: geometry_msgs/TransformStamped\n{STAMPED}{HEADER}{TRANSFORM}{QUATERNION}"
            ),
            |ns, p, q| {
                let two = Cdr::new().put(2_u32.to_le_bytes());
                transform(transform(two, 1, "arm", &elsewhere(), q), ns, "base_link", p, q).0
            },
        ),
        ros(
            "geometry_msgs/msg/TransformStamped",
            format!("{STAMPED}{HEADER}{TRANSFORM}{QUATERNION}"),
            |ns, p, q| transform(Cdr::new(), ns, "base_link", p, q).0,
        ),
        ros("geometry_msgs/msg/PoseStamped", format!("{POSE}{HEADER}{QUATERNION}"), |ns, p, q| {
            pose(header(Cdr::new(), ns), p, q).0
        }),
        foxglove::<fox::PoseInFrame>(|ns, p, q| {
            encoded(&fox::PoseInFrame {
                timestamp: Some(stamp(ns)),
                frame_id: "world".to_owned(),
                pose: Some(fox::Pose {
                    position: Some(fox::Vector3 { x: p.x, y: p.y, z: p.z }),
                    orientation: Some(fox_quaternion(q)),
                }),
            })
        }),
        foxglove::<fox::FrameTransforms>(|ns, p, q| {
            let arm = fox_transform(1, "arm", &elsewhere(), q);
            let transforms = vec![arm, fox_transform(ns, "base_link", p, q)];
            encoded(&fox::FrameTransforms { transforms })
        }),
    ]
}

fn flight(form: &Form) -> Vec<u8> {
    let mut writer = mcap::WriteOptions::new()
        .compression_threads(0)
        .create(Cursor::new(Vec::new()))
        .expect("a writer");
    let (name, encoding, definition) = &form.schema;
    let schema = writer.add_schema(name, encoding, definition).expect("a schema");
    let channel =
        writer.add_channel(schema, "/pose", form.encoding, &BTreeMap::new()).expect("a channel");
    for i in 0..1000_u64 {
        let t_s = i as f64 * 0.01;
        let ns = 1_700_000_000_000_000_000 + i * 10_000_000;
        let q = UnitQuaternion::from_euler_angles(0.1, -0.2, yaw(t_s));
        let log_time = ns + LATE_NS;
        let header = MessageHeader {
            channel_id: channel,
            sequence: i as u32,
            log_time,
            publish_time: log_time,
        };
        let message = (form.message)(ns, &truth(t_s).0, &q);
        writer.write_to_known_channel(&header, &message).expect("written");
    }
    writer.finish().expect("finished");
    writer.into_inner().into_inner()
}

#[test]
fn transforms_and_poses_of_ros_and_foxglove_tell_the_same_flight() {
    let map = Map::over_generic(Map::default()).expect("the generic map");
    for (number, form) in forms().iter().enumerate() {
        let name = &form.schema.0;
        let path = file(&format!("transforms_{number}.mcap"), &flight(form));
        let (signals, recorded) = read(&path, &map);
        assert!(signals.notes.iter().all(|note| !note.contains("decoded")), "{name}");
        assert_eq!(recorded.instants.len(), 1000, "{name}");
        for (tick, instant) in recorded.instants.iter().enumerate() {
            let t_s = tick as f64 * 0.01;
            let p = truth(t_s).0;
            let wanted = [p.x, p.y, p.z, 0.1, -0.2, yaw(t_s)];
            for (row, wanted) in wanted.iter().enumerate() {
                let found = instant.chi[row].expect("known");
                // Ticks coincide with samples. A present time in f64 is exact to 0.2 us, and the error of a cubic is smaller.
                assert!((found - wanted).abs() < 1e-6, "{name} {tick} {row}: {found} {wanted}");
            }
        }
    }
}
