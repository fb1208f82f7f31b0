//! A recorded flight in the formats of the two other viewers: commands for a page of MeshCat's, and viser's recording.
//!
//! In: a scene and the ticks of its flight. Out: bytes. State: none.

use crate::server::viewers::flown::Flown;
use crate::server::viewers::{meshcat_animation, pack, viser_recording};
use twin_core::tick::Tick;
use twin_record::scene::Scene;

/// The commands that draw a flight and play it, each as MeshCat reads it.
pub fn meshcat(scene: &Scene, ticks: &[Tick]) -> Vec<Vec<u8>> {
    let flown = Flown::new(scene, ticks);
    meshcat_animation::commands(&flown).iter().map(pack::encode).collect()
}

/// The flight as a `.viser` file: its inner bytes, to be compressed with zstd after their length.
pub fn viser(scene: &Scene, ticks: &[Tick]) -> Vec<u8> {
    viser_recording::inner(&Flown::new(scene, ticks))
}
