//! Encodes a flight as a viser recording: the messages that draw the scene, then for each picture the messages that move nodes.
//! Each message has its time.

use crate::server::viewers::VISER;
use crate::server::viewers::drawing::SentPoses;
use crate::server::viewers::pack::{map, numbers};
use crate::server::viewers::recorded_drawing::RecordedDrawing;
use crate::server::viewers::viser::{CAMERA_M, LOOK_AT_M};
use crate::server::viewers::viser_frame::Batch;
use crate::server::viewers::viser_move::Mover;
use crate::server::viewers::viser_scene as scene;

/// The inner bytes of a `.viser` file.
pub(super) fn inner(flown: &RecordedDrawing) -> Vec<u8> {
    let mut batch = Batch::default();
    for (kind, key, value) in [
        ("SetCameraPositionMessage", "position", CAMERA_M),
        ("SetCameraLookAtMessage", "look_at", LOOK_AT_M),
    ] {
        batch.push(&map! { "type" => kind, key => numbers(value), "initial" => true });
    }
    batch.push(&scene::light());
    scene::draw(&flown.drawing, &mut batch);
    for (path, rgb, ends) in flown.drawn_lines() {
        scene::update_line(path, rgb, ends.to_vec(), &mut batch);
    }
    let mut times_s = vec![0.0; batch.len()];
    let movers: Vec<Mover> = flown.drawing.moving.iter().map(|path| Mover::new(path)).collect();
    let mut told = SentPoses::default();
    let mut duration_s = 0.0;
    for (t_s, picture) in &flown.pictures {
        for (node, pose) in told.news(flown.drawing.poses(picture)) {
            movers[node].place(pose, &mut batch);
        }
        times_s.resize(batch.len(), *t_s);
        duration_s = *t_s;
    }
    batch.encode_recording(&times_s, duration_s, VISER.version)
}
