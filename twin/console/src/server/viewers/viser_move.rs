//! The two encoded messages that move a viser node. From pose to pose only the numbers at the end of their bytes change.

use rmpv::Value;

use crate::server::viewers::pack::{encode, map, numbers, overwrite_f32};
use crate::server::viewers::viser_frame::Batch;

/// The encoded messages that move one node.
#[derive(Clone, Debug)]
pub(super) struct Mover {
    position: Vec<u8>,
    orientation: Vec<u8>,
}

impl Mover {
    /// The messages for the node at a path.
    pub(super) fn new(path: &str) -> Self {
        let message = |kind: &str, key: &str, length: usize| {
            let numbers = Value::Array(vec![Value::F32(0.0); length]);
            encode(&map! { "type" => kind, "name" => path, "owner" => "", key => numbers })
        };
        Self {
            position: message("SetPositionMessage", "position", 3),
            orientation: message("SetOrientationMessage", "wxyz", 4),
        }
    }

    /// Moves the node to the pose `[x y z w x y z]` in the world, m.
    pub(super) fn place(&self, pose: [f32; 7], batch: &mut Batch) {
        let (position, turn) = pose.split_at(3);
        batch.push_encoded(&self.position, |bytes| overwrite_f32(bytes, position));
        batch.push_encoded(&self.orientation, |bytes| overwrite_f32(bytes, turn));
    }
}

/// The message that moves a node to `xyz` in the frame of its parent, m.
pub(super) fn position(name: &str, xyz: [f64; 3]) -> Value {
    map! { "type" => "SetPositionMessage", "name" => name, "position" => numbers(xyz), "owner" => "" }
}
