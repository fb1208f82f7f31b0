//! Encodes a recorded flight for the two stock viewers: as commands for a MeshCat page, and as a viser recording.
//!
//! In: a scene and the ticks of its flight. Out: bytes. State: none.

use crate::server::viewers::recorded_drawing::RecordedDrawing;
use crate::server::viewers::{meshcat_animation, pack, viser_recording};
use twin_core::tick::Tick;
use twin_record::scene::Scene;

/// The encoded MeshCat commands that draw a flight and play it.
pub fn meshcat(scene: &Scene, ticks: &[Tick]) -> Vec<Vec<u8>> {
    let flown = RecordedDrawing::new(scene, ticks);
    meshcat_animation::commands(&flown).iter().map(pack::encode).collect()
}

/// The inner bytes of the flight's `.viser` file. The file has their length, and then these bytes compressed with zstd.
pub fn viser(scene: &Scene, ticks: &[Tick]) -> Vec<u8> {
    viser_recording::inner(&RecordedDrawing::new(scene, ticks))
}
