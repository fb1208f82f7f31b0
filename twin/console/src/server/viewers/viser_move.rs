//! The two messages that move a node of viser's, encoded once: of their bytes only the numbers at the end change.

use rmpv::Value;

use crate::server::viewers::pack::{encode, map, numbers, overwrite_f32};
use crate::server::viewers::viser_frame::Batch;

/// Moves one node.
#[derive(Clone, Debug)]
pub(super) struct Mover {
    position: Vec<u8>,
    orientation: Vec<u8>,
}

impl Mover {
    /// Of the node at a path.
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

    /// To `[x y z w x y z]` in the world, m.
    pub(super) fn place(&self, pose: [f32; 7], batch: &mut Batch) {
        let (position, turn) = pose.split_at(3);
        batch.push_encoded(&self.position, |bytes| overwrite_f32(bytes, position));
        batch.push_encoded(&self.orientation, |bytes| overwrite_f32(bytes, turn));
    }
}

/// Moves a node within its parent, m.
pub(super) fn position(name: &str, xyz: [f64; 3]) -> Value {
    map! { "type" => "SetPositionMessage", "name" => name, "position" => numbers(xyz), "owner" => "" }
}
