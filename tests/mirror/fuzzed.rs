//! The bodies that read damaged input, for the seeded loop of this suite and the targets of cargo-fuzz. They must not panic, hang, or
//! give a number that is not finite.

use std::io::Cursor;
use std::path::Path;
use std::sync::LazyLock;

use twin_foreign::cdr::{decode, decode_packed};
use twin_foreign::gather::gather_from;
use twin_foreign::protobuf::Descriptor;
use twin_foreign::recorded::on_ticks;
use twin_foreign::schema::Layout;
use twin_foreign::signals::signals;
use twin_foreign::{Map, OpenedFlight, RecordedFlight, Survey};

/// A message definition with every construct that a definition may have.
pub(super) const DEFINITION: &str = "uint8 a\nfloat64 b\nstring name\nfloat32[] values\nInner[] inner\nstring[<=4] names\n===\nMSG: p/Inner\nint16 c\nfloat32[3] d\n";

/// Recordings that are longer are not put onto ticks, because damage can move a clock by hours; other tests cover clocks.
const SHORT_S: f64 = 100.0;

/// Ticks of a part of a long flight.
const PART: usize = 50;

static MAP: LazyLock<Map> =
    LazyLock::new(|| Map::over_generic(Map::default()).expect("the generic map"));

static LAYOUT: LazyLock<Layout> =
    LazyLock::new(|| Layout::parse("p/msg/Outer", DEFINITION).expect("a definition"));

/// A `FileDescriptorSet` of a type that contains itself, a text and packed numbers: `p.T { T a = 1; string b = 2; repeated double c
/// = 3; }`.
const DESCRIPTOR: &[u8] = b"\x0a/\x12\x01p\x22*\x0a\x01T\x12\x0f\x0a\x01a\x18\x01\x20\x01(\x0b2\x04.p.T\x12\x09\x0a\x01b\x18\x02\x20\x01(\x09\x12\x09\x0a\x01c\x18\x03\x20\x03(\x01";

static DESCRIBED: LazyLock<Descriptor> =
    LazyLock::new(|| Descriptor::parse("p.T", DESCRIPTOR).expect("a descriptor"));

/// A message of [`DEFINITION`].
pub(super) fn message() -> Vec<u8> {
    [0, 1, 0, 0, 7, 0, 0, 0].into_iter().chain([2; 160]).collect()
}

fn assert_finite(flight: &RecordedFlight) {
    for instant in &flight.instants {
        let all = [instant.chi, instant.chi_dot, instant.chi_ddot, instant.tau];
        assert!(all.iter().flatten().flatten().copied().all(f64::is_finite));
    }
}

/// Reads an MCAP or ULog file from its first to its last byte and puts it onto ticks; returns whether it could be read.
pub(super) fn file(bytes: &[u8]) -> bool {
    let Ok(survey) = Survey::read_from(&mut &*bytes) else { return false };
    if let Ok(gathered) = gather_from(&mut &*bytes, &MAP)
        && survey.duration_s < SHORT_S
        && let Ok(flight) = on_ticks(&signals(&gathered), &MAP.vehicle)
    {
        assert_finite(&flight);
    }
    true
}

/// Reads a long flight through the index of its file; returns whether it could be read.
pub(super) fn indexed(bytes: &[u8]) -> bool {
    let input = Box::new(Cursor::new(bytes.to_vec()));
    let Ok(Some(opened)) = OpenedFlight::open_long(Path::new("damaged"), None, input) else {
        return false;
    };
    if let Some(parts) = &opened.long {
        let ticks = parts.ticks();
        for from in [0, ticks / 2, ticks.saturating_sub(PART)] {
            let part = parts.part(from, (from + PART).min(ticks));
            assert_eq!(part.instants.len(), (from + PART).min(ticks) - from);
            assert_finite(&part);
        }
    }
    assert_finite(&opened.recorded);
    true
}

/// Decodes a message by a valid definition, as CDR and as ULog.
pub(super) fn of_definition(bytes: &[u8]) {
    let _ = (decode(&LAYOUT, bytes), decode_packed(&LAYOUT, bytes), DESCRIBED.decode(bytes));
}

/// Reads a definition, and a message by it.
pub(super) fn definition(text: &[u8]) {
    if let Ok(descriptor) = Descriptor::parse("p.T", text) {
        let _ = (descriptor.decode(&message()), descriptor.decode(text));
    }
    let text = String::from_utf8_lossy(text);
    let name = "p/msg/Outer";
    let layouts =
        [Layout::parse(name, &text), Layout::parse_idl(name, &text), Layout::parse_ulog(&text)];
    for layout in layouts.iter().flatten() {
        let _ = (decode(layout, &message()), decode_packed(layout, &message()));
    }
}

/// Reads a topic map.
pub(super) fn map(text: &[u8]) {
    if let Ok(map) = Map::parse(&String::from_utf8_lossy(text), "damaged") {
        let _ = map.rule("/fmu/out/vehicle_odometry", "px4_msgs/msg/VehicleOdometry");
    }
}
