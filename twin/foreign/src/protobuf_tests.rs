use foxglove::Encode;
use foxglove::messages::{
    FrameTransform, FrameTransforms, JointState, JointStates, Quaternion, Timestamp, Vector3,
};

use super::*;
use crate::value::Path;

/// A length-delimited field, encoded by hand.
fn inside(number: u8, bytes: &[u8]) -> Vec<u8> {
    [&[(number << 3) | 2, bytes.len() as u8][..], bytes].concat()
}

fn text(number: u8, text: &str) -> Vec<u8> {
    inside(number, text.as_bytes())
}

/// Schema and bytes of a message, as Foxglove's own library writes them.
fn written<M: Encode>(message: &M) -> (Descriptor, Vec<u8>) {
    let schema = M::get_schema().unwrap();
    let mut bytes = Vec::new();
    message.encode(&mut bytes).unwrap();
    (Descriptor::parse(&schema.name, &schema.data).unwrap(), bytes)
}

fn transforms() -> FrameTransforms {
    let one = |name: &str, x: f64| FrameTransform {
        timestamp: Some(Timestamp::new(1_700_000_000, 5)),
        parent_frame_id: "world".to_owned(),
        child_frame_id: name.to_owned(),
        translation: Some(Vector3 { x, y: 0.0, z: -2.5 }),
        rotation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
    };
    FrameTransforms { transforms: vec![one("arm", 1.0), one("base_link", 2.0)] }
}

#[test]
fn what_foxgloves_library_wrote_is_read_with_its_defaults() {
    let (descriptor, bytes) = written(&transforms());
    let value = descriptor.decode(&bytes).unwrap();
    let number = |path: &str| value.number(&Path::parse(path).unwrap());
    assert_eq!(number("transforms[child_frame_id=base_link].translation.x"), Some(2.0));
    assert_eq!(number("transforms[1].translation.z"), Some(-2.5));
    // The library does not send zeros.
    assert_eq!(number("transforms[child_frame_id=arm].translation.y"), Some(0.0));
    assert_eq!(number("transforms[0].timestamp.seconds"), Some(1.7e9));
    let joints = JointStates {
        timestamp: None,
        joints: vec![JointState {
            name: "q0".to_owned(),
            position: Some(0.25),
            velocity: None,
            acceleration: None,
            effort: None,
        }],
    };
    let (descriptor, bytes) = written(&joints);
    let value = descriptor.decode(&bytes).unwrap();
    assert_eq!(value.number(&Path::parse("joints[name=q0].position").unwrap()), Some(0.25));
    assert!(value.at(&Path::parse("timestamp").unwrap()).is_none());
}

#[test]
fn numbers_of_every_kind_come_back_packed_and_not() {
    // A descriptor by hand, after descriptor.proto: message T of package p with one repeated field a of each type.
    let set = |kind: u64| {
        let field = [text(1, "a"), vec![3 << 3, 1, 4 << 3, 3, 5 << 3, kind as u8]].concat();
        let message = [text(1, "T"), inside(2, &field)].concat();
        inside(1, &[text(2, "p"), inside(4, &message)].concat())
    };
    for (kind, sent, wanted) in [
        (DOUBLE, (-1.5_f64).to_le_bytes().to_vec(), -1.5),
        (FLOAT, 0.5_f32.to_le_bytes().to_vec(), 0.5),
        (INT32, vec![0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1], -1.0),
        (ENUM, vec![0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1], -1.0),
        (UINT32, vec![0xAC, 2], 300.0),
        (SINT32, vec![3], -2.0),
        (SFIXED32, (-7_i32).to_le_bytes().to_vec(), -7.0),
        (SFIXED64, (-8_i64).to_le_bytes().to_vec(), -8.0),
        (BOOL, vec![1], 1.0),
        // `prost-reflect` reads a boolean of another number than 0 as true, too.
        (BOOL, vec![2], 1.0),
    ] {
        let descriptor = Descriptor::parse("p.T", &set(kind)).unwrap();
        let single = [vec![(1 << 3) | wire_of(kind)], sent.clone()].concat();
        let packed = inside(1, &sent);
        for bytes in [single, packed] {
            let value = descriptor.decode(&bytes).unwrap();
            assert_eq!(value.at(&Path::parse("a").unwrap()).unwrap().numbers(), [wanted], "{kind}");
        }
    }
}

#[test]
fn a_message_cut_anywhere_ends_and_a_type_that_contains_itself_ends() {
    let (descriptor, bytes) = written(&transforms());
    let bad = (0..bytes.len()).filter(|end| descriptor.decode(&bytes[..*end]).is_err()).count();
    // A message that is cut between two transforms, or before its first byte, is a shorter whole message.
    assert_eq!(bad, bytes.len() - 2);
    let field = [text(1, "a"), vec![3 << 3, 1, 5 << 3, MESSAGE as u8], text(6, ".T")].concat();
    let set = inside(1, &inside(4, &[text(1, "T"), inside(2, &field)].concat()));
    let descriptor = Descriptor::parse("T", &set).unwrap();
    let deep = (0..40).fold(Vec::new(), |inner: Vec<u8>, _| inside(1, &inner));
    assert!(descriptor.decode(&deep).unwrap_err().contains("deeper"));
    assert!(Descriptor::parse("U", &set).unwrap_err().contains("no type U"));
}

/// A length-delimited field with a length of any size.
fn long(number: u8, bytes: &[u8]) -> Vec<u8> {
    let (mut length, mut head) = (bytes.len(), vec![(number << 3) | 2]);
    while length >= 0x80 {
        head.push((length & 0x7F) as u8 | 0x80);
        length >>= 7;
    }
    [&head[..], &[length as u8], bytes].concat()
}

/// The set of a type `p.T0` with `count` fields, each of another type; and as many types.
fn many(count: usize) -> Vec<u8> {
    let field = |n: usize| {
        let number = [&[3 << 3][..], &[(n & 0x7F) as u8 | 0x80, (n >> 7) as u8]].concat();
        let kind = format!(".p.T{n}");
        let parts = [text(1, "f"), number, vec![4 << 3, 1, 5 << 3, 11], text(6, &kind)];
        long(2, &parts.concat())
    };
    let fields: Vec<u8> = (1..count).flat_map(field).collect();
    let first = long(4, &[text(1, "T0"), fields].concat());
    let others = (1..count).flat_map(|n| long(4, &text(1, &format!("T{n}"))));
    long(1, &[text(2, "p"), first, others.collect()].concat())
}

#[test]
fn the_work_of_a_descriptor_grows_with_its_fields_and_not_with_their_square() {
    let growth = twin_input::work::growth(200, &mut |count| {
        let descriptor = Descriptor::parse("p.T0", &many(count)).unwrap();
        // Every field is sent once, empty.
        let sent = |n: usize| {
            [(n << 3 | 2) as u8 | 0x80, (n >> 4) as u8 & 0x7F | 0x80, (n >> 11) as u8, 0]
        };
        let message: Vec<u8> = (1..count).flat_map(sent).collect();
        descriptor.decode(&message).unwrap();
    });
    assert!(
        growth < twin_input::work::LINEAR,
        "four times the fields took {growth:.1} times the steps"
    );
}

#[test]
fn a_type_name_that_every_nested_type_would_copy_is_limited() {
    let set = |length: usize| long(1, &long(4, &long(1, "n".repeat(length).as_bytes())));
    let most = twin_input::budget::NAME_BYTES.count();
    assert!(Descriptor::parse(&"n".repeat(most), &set(most)).is_ok());
    let said = Descriptor::parse("n", &set(most + 1)).unwrap_err();
    assert!(said.contains("1025 bytes in one name"), "{said}");
}
