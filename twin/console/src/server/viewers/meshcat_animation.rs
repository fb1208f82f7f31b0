//! The command `set_animation` of MeshCat, with the poses of a whole flight as key frames, and the commands that draw the flight.

use rmpv::Value;

use crate::server::viewers::meshcat::{CAMERA, CAMERA_Y_UP};
use crate::server::viewers::meshcat_command::set_property;
use crate::server::viewers::meshcat_object::{set_line_segments, set_object, set_transform};
use crate::server::viewers::pack::{map, numbers};
use crate::server::viewers::recorded_drawing::{PICTURES_HZ, RecordedDrawing};

/// A key frame: number of frames after the start, and pose `[x y z w x y z]` in the world, m.
type Key = (u32, [f64; 7]);

/// The commands that draw the flight and play it.
pub(super) fn commands(flown: &RecordedDrawing) -> Vec<Value> {
    let drawing = &flown.drawing;
    let mut commands: Vec<Value> = drawing.parts.iter().map(set_object).collect();
    commands.extend(drawing.nodes.iter().map(|node| set_transform(&node.path, node.pose)));
    let lines = flown.drawn_lines();
    commands.extend(lines.map(|(path, rgb, ends)| set_line_segments(path, rgb, ends.to_vec())));
    commands.push(set_property(CAMERA, "position", numbers(CAMERA_Y_UP)));
    let clips: Vec<(&str, Vec<Key>)> = drawing
        .moving
        .iter()
        .enumerate()
        .map(|(index, path)| (path.as_str(), keys(flown, index)))
        .filter(|(_, keys)| !keys.is_empty())
        .collect();
    commands.push(set_animation(PICTURES_HZ, &clips));
    commands
}

/// The known poses of one node as key frames. A pose between two equal poses is left out.
fn keys(flown: &RecordedDrawing, index: usize) -> Vec<Key> {
    let poses = flown.pictures.iter().filter_map(|(t_s, picture)| {
        let pose = picture.poses.iter().chain([&picture.ghost]).nth(index)?;
        let frame = (t_s * f64::from(PICTURES_HZ)).round() as u32;
        pose.iter().all(|value| value.is_finite()).then(|| (frame, pose.map(f64::from)))
    });
    let mut keys: Vec<Key> = Vec::new();
    for (frame, pose) in poses {
        if let [.., (_, before), last] = &mut keys[..]
            && same(before, &pose)
            && same(&last.1, &pose)
        {
            last.0 = frame;
            continue;
        }
        keys.push((frame, pose));
    }
    keys
}

/// Whether two poses have the same bits, which is so in all pictures in which a body rests.
fn same(one: &[f64; 7], other: &[f64; 7]) -> bool {
    one.map(f64::to_bits) == other.map(f64::to_bits)
}

/// The command that plays these clips once. A clip has the path of a node and its key frames.
fn set_animation(frames_per_s: u32, clips: &[(&str, Vec<Key>)]) -> Value {
    let key = |frame: u32, value: Value| map! { "time" => frame, "value" => value };
    let animation = |(path, keys): &(&str, Vec<Key>)| {
        let positions =
            keys.iter().map(|(frame, [x, y, z, ..])| key(*frame, numbers([*x, *y, *z])));
        let turns =
            keys.iter().map(|(frame, [.., w, x, y, z])| key(*frame, numbers([*x, *y, *z, *w])));
        let track = |name: &str, kind: &str, keys: Vec<Value>| {
            map! { "name" => name, "type" => kind, "keys" => Value::Array(keys) }
        };
        let tracks = vec![
            track(".position", "vector3", positions.collect()),
            track(".quaternion", "quaternion", turns.collect()),
        ];
        let clip =
            map! { "fps" => frames_per_s, "name" => "default", "tracks" => Value::Array(tracks) };
        map! { "path" => *path, "clip" => clip }
    };
    map! {
        "type" => "set_animation",
        "animations" => Value::Array(clips.iter().map(animation).collect()),
        "options" => map! { "play" => true, "repetitions" => 1 },
        "path" => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::viewers::meshcat_object::tests::reference;
    use crate::server::viewers::pack::encode;

    #[test]
    fn an_animation_has_the_bytes_of_meshcat_python() {
        // The cosine of an eighth of a turn, and its sine as Python computes it: one rounding lower.
        let cosine = std::f64::consts::FRAC_1_SQRT_2;
        let sine = cosine.next_down();
        let keys = vec![
            (0, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
            (30, [0.5, -1.0, 2.0, cosine, 0.0, 0.0, sine]),
        ];
        let Some(wanted) = reference("set_animation") else { return };
        assert_eq!(encode(&set_animation(30, &[("/meshcat/box", keys)])), wanted);
    }
}
