//! A recorded flight for both viewers: pictures, and lines through the whole flight.

use crate::server::telemetry::Picture;
use crate::server::viewers::drawing::Drawing;
use crate::server::viewers::trail::LINES;
use twin_core::tick::Tick;
use twin_record::scene::Scene;

/// Pictures per second.
pub(super) const PICTURES_HZ: u32 = 25;

/// Ticks of 10 ms per picture.
const EVERY: u64 = 4;

/// Most points of a line through the whole flight.
const MOST_POINTS: usize = 2000;

/// A recorded flight as the viewers draw it. Each picture has its time since the start, s.
pub(super) struct RecordedDrawing {
    pub(super) drawing: Drawing,
    pub(super) pictures: Vec<(f64, Picture)>,
    /// Segments of the lines through the whole flight, in the order of [`LINES`]. A segment has two ends `[x y z]`, m.
    pub(super) lines: [Vec<f32>; 2],
}

impl RecordedDrawing {
    pub(super) fn new(scene: &Scene, ticks: &[Tick]) -> Self {
        let start_s = ticks.first().map_or(0.0, |tick| tick.measurement.t_s);
        let chosen = ticks.iter().filter(|tick| tick.index.is_multiple_of(EVERY));
        let pictures: Vec<(f64, Picture)> = chosen
            .map(|tick| (tick.measurement.t_s - start_s, Picture::new(scene, tick, &[])))
            .collect();
        let base = scene.moving().position(|body| body.name == scene.base_body);
        let flown = |picture: &Picture| base.and_then(|base| picture.poses.get(base)).copied();
        let lines = [
            segments(pictures.iter().filter_map(|(_, picture)| flown(picture))),
            segments(pictures.iter().map(|(_, picture)| picture.ghost)),
        ];
        Self { drawing: Drawing::new(scene), pictures, lines }
    }

    /// Path, colour and segments of each line that has points.
    pub(super) fn drawn_lines(&self) -> impl Iterator<Item = (&'static str, [u8; 3], &[f32])> {
        let lines = LINES.iter().zip(&self.lines);
        lines
            .filter(|(_, ends)| !ends.is_empty())
            .map(|((path, _, rgb), ends)| (*path, *rgb, &ends[..]))
    }
}

/// Both ends of the segments between successive positions, thinned out to [`MOST_POINTS`].
fn segments(poses: impl Iterator<Item = [f32; 7]>) -> Vec<f32> {
    let points: Vec<[f32; 3]> = poses
        .map(|[x, y, z, ..]| [x, y, z])
        .filter(|point| point.iter().all(|value| value.is_finite()))
        .collect();
    let step = points.len().div_ceil(MOST_POINTS).max(1);
    let kept: Vec<[f32; 3]> = points.into_iter().step_by(step).collect();
    kept.windows(2).flatten().copied().flatten().collect()
}
