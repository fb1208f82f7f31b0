//! Wavefront OBJ: `v` and `f` lines; polygons become fans. Materials, normals and texture are not read.

use super::Triangles;

pub(super) fn parse(bytes: &[u8]) -> Result<Triangles, String> {
    let mut mesh = Triangles::default();
    for (line, text) in (1..).zip(String::from_utf8_lossy(bytes).lines()) {
        let mut words = text.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                let [x, y, z, ..] = numbers[..] else {
                    return Err(format!("line {line}: a vertex needs 3 numbers"));
                };
                mesh.vertices.push([x, y, z]);
            }
            Some("f") => {
                let corners: Vec<u32> = words
                    .map(|word| corner(word, mesh.vertices.len()))
                    .collect::<Option<_>>()
                    .ok_or_else(|| format!("line {line}: a face names a vertex not yet given"))?;
                if corners.len() < 3 {
                    return Err(format!("line {line}: a face with {} corners", corners.len()));
                }
                let fan = corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]);
                mesh.triangles.extend(fan);
            }
            _ => {}
        }
    }
    Ok(mesh)
}

/// The index from 0 of the corner `7`, `7/1` or `7//3`; `-1` is the newest vertex.
fn corner(word: &str, vertices: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let count = i64::try_from(vertices).ok()?;
    let index = if number < 0 { count.checked_add(number)? } else { number - 1 };
    (0..count).contains(&index).then_some(index as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_is_two_triangles_and_negative_indices_count_back() {
        let text =
            "v 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0\nv 0 1 0\nf 1/1 2//2 3 4/1/1\nf -4 -3 -1\n";
        let vertices = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 1, 3]];
        assert_eq!(parse(text.as_bytes()), Ok(Triangles { vertices, triangles }));
    }

    #[test]
    fn broken_faces_and_vertices_are_refused_with_their_line() {
        for text in ["v 0 0\n", "v 0 0 0\nf 1 1\n", "v 0 0 0\nf 1 1 2\n", "v 0 0 0\nf 0 1 1\n"] {
            assert!(parse(text.as_bytes()).unwrap_err().contains("line "), "accepted {text:?}");
        }
        assert!(parse(b"v 0 0 0\nf 1 1 -9223372036854775808\n").is_err());
    }
}
