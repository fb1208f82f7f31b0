//! viser's recording of a flight: the scene, then for each picture what moved, each message with its time.

use crate::server::viewers::export::Flown;
use crate::server::viewers::pack::{map, numbers};
use crate::server::viewers::viser::{CAMERA_M, LOOK_AT_M};
use crate::server::viewers::viser_frame::Batch;
use crate::server::viewers::viser_scene as scene;
use crate::server::viewers::{VISER, viser_label as label};

/// The inner bytes of a `.viser` file.
pub(super) fn inner(flown: &Flown) -> Vec<u8> {
    let mut batch = Batch::default();
    for (kind, key, value) in [
        ("SetCameraPositionMessage", "position", CAMERA_M),
        ("SetCameraLookAtMessage", "look_at", LOOK_AT_M),
    ] {
        batch.push(map! { "type" => kind, key => numbers(value), "initial" => true });
    }
    batch.push(scene::light());
    scene::draw(&flown.drawing, &mut batch);
    batch.push(label::reference());
    for (path, rgb, ends) in flown.drawn_lines() {
        scene::update_line(path, rgb, ends.to_vec(), &mut batch);
    }
    let mut times_s = vec![0.0; batch.len()];
    let mut told = vec![[f32::NAN; 7]; flown.drawing.moving.len()];
    let mut duration_s = 0.0;
    for (t_s, picture) in &flown.pictures {
        for ((path, pose), told) in flown.drawing.poses(picture).zip(&mut told) {
            let known = pose.iter().all(|value| value.is_finite());
            if known && pose.map(f32::to_bits) != told.map(f32::to_bits) {
                scene::place(path, pose, &mut batch);
                *told = pose;
            }
        }
        times_s.resize(batch.len(), *t_s);
        duration_s = *t_s;
    }
    batch.encode_recording(&times_s, duration_s, VISER.version)
}
