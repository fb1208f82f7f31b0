//! Every limit on what is read. A limit lies far above what a recorder, an editor or an exporter writes, and far below what exhausts
//! a machine.

use crate::Limit;

/// Bytes in a mebibyte.
const MIB: u64 = 1 << 20;

/// Remedy for a file that is far longer than files of its kind are.
const OTHER_FILE: &str = "check that the path names the file that you mean";

/// Remedy for a recording that asks for more than recorders write.
const DAMAGED: &str =
    "the file is damaged, or made to exhaust the machine; record or copy it again";

/// Bytes of a scenario; twenty thousand faults take 2 MiB.
pub const SCENARIO_BYTES: Limit = Limit::new(16 * MIB, "bytes of TOML", OTHER_FILE);

/// Bytes of a map from messages to quantities, or of the settings of a training.
pub const SETTINGS_BYTES: Limit = Limit::new(MIB, "bytes of TOML", OTHER_FILE);

/// Elements of one list in a scenario: faults, disturbances, checks, way-points.
pub const LIST_ITEMS: Limit = Limit::new(20_000, "elements in one list", "split the scenario");

/// Checks of a scenario, and demands on its events.
pub const SCENARIO_CHECKS: Limit = Limit::new(1000, "checks", "split the scenario");

/// Values in a scenario, all tables and lists together.
pub const TOML_VALUES: Limit = Limit::new(500_000, "values", "split the scenario");

/// Bytes of a golden run, or of the report of a test run.
pub const REPORT_BYTES: Limit = Limit::new(256 * MIB, "bytes", OTHER_FILE);

/// Bytes of a URDF; ten thousand links take 4 MiB.
pub const URDF_BYTES: Limit = Limit::new(64 * MIB, "bytes of URDF", OTHER_FILE);

/// Links of a URDF.
pub const LINKS: Limit = Limit::new(10_000, "links", "merge links that do not move");

/// Joints of a URDF.
pub const JOINTS: Limit = Limit::new(10_000, "joints", "merge links that do not move");

/// Joints of a simulated vehicle that move: the work of a step grows with their cube.
pub const MOVING_JOINTS: Limit =
    Limit::new(64, "joints that move", "make the joints fixed that the flight does not need");

/// Attributes of one XML element: the parser compares each with each.
pub const ATTRIBUTES: Limit = Limit::new(256, "attributes in one element", OTHER_FILE);

/// Bytes of one mesh file.
pub const MESH_BYTES: Limit = Limit::new(256 * MIB, "bytes of mesh", "simplify the mesh");

/// Bytes of all mesh files of a vehicle, each counted as often as the URDF names it.
pub const ALL_MESH_BYTES: Limit =
    Limit::new(1024 * MIB, "bytes of meshes", "simplify the meshes, or name them less often");

/// Triangles of one mesh. A COLLADA node may instance a mesh many times, so a small file can ask for very many.
pub const TRIANGLES: Limit = Limit::new(2_000_000, "triangles", "simplify the mesh");

/// Bytes of a mesh or picture that Foxglove's server hands out.
pub const ASSET_BYTES: Limit = Limit::new(32 * MIB, "bytes of an asset", "simplify the mesh");

/// Bytes of a file of a stock viewer.
pub const VIEWER_BYTES: Limit =
    Limit::new(64 * MIB, "bytes of a viewer", "install it again: twin viewers fetch");

/// Bytes of a file of weights; the paper's network takes 80 MiB.
pub const WEIGHTS_BYTES: Limit = Limit::new(1024 * MIB, "bytes of weights", OTHER_FILE);

/// Bytes of a checkpoint of a training, which holds four sets of weights.
pub const CHECKPOINT_BYTES: Limit = Limit::new(4096 * MIB, "bytes of a checkpoint", OTHER_FILE);

/// Bytes of one record of a recording, and of one chunk, packed or unpacked.
pub const RECORD_BYTES: Limit = Limit::new(256 * MIB, "bytes in one record", DAMAGED);

/// Bytes that may be unpacked before the ratio counts.
pub const UNPACKED_BYTES: u64 = 256 * MIB;

/// Bytes that one compressed byte may become, over all chunks that were read. Telemetry reaches 20, images of one colour 200.
pub const UNPACKED_RATIO: u64 = 400;

/// Ticks of a flight: ten hours.
pub const TICKS: Limit = Limit::new(3_600_000, "ticks", "split the recording");

/// Bytes of the files that are attached to a recording of this program, and of its metadata.
pub const ATTACHED_BYTES: Limit = Limit::new(256 * MIB, "bytes of attachments", DAMAGED);

/// Channels of a recording or of a stream; MCAP numbers them with 16 bits.
pub const CHANNELS: Limit = Limit::new(65_535, "channels", "record fewer topics");

/// Definitions of schemas in a recording or in a stream.
pub const SCHEMAS: Limit = Limit::new(65_535, "schemas", "record fewer topics");

/// Bytes of one message definition; the largest of ROS and PX4 take 100 KiB.
pub const SCHEMA_BYTES: Limit = Limit::new(4 * MIB, "bytes in one message definition", DAMAGED);

/// Bytes of all message definitions of a recording or of a stream.
pub const ALL_SCHEMA_BYTES: Limit = Limit::new(256 * MIB, "bytes of message definitions", DAMAGED);

/// Bytes of a name in a message definition.
pub const NAME_BYTES: Limit = Limit::new(1024, "bytes in one name", DAMAGED);

/// Nesting of message definitions, and of the types in an IDL.
pub const TYPE_DEPTH: Limit =
    Limit::new(16, "levels of types", "a type contains itself, or the definition is damaged");

/// Bytes of one JSON message that is decoded: its values take ten times as much memory.
pub const JSON_BYTES: Limit = Limit::new(16 * MIB, "bytes in one JSON message", DAMAGED);

/// Samples of one quantity that a live stream keeps: ten minutes at 2 kHz.
pub const LIVE_SAMPLES: Limit = Limit::new(1_200_000, "samples", "send fewer messages");

/// Bytes of one message of a live stream.
pub const STREAM_MESSAGE_BYTES: Limit = Limit::new(64 * MIB, "bytes in one message", DAMAGED);
