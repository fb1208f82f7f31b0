//! STL, binary and text. Source: <https://www.loc.gov/preservation/digital/formats/fdd/fdd000506.shtml>

use super::Triangles;

/// Length of the free text before the triangle count.
const HEADER_BYTES: usize = 80;
/// Length of a triangle: normal and three corners (12 × f32), and a 16-bit attribute.
const TRIANGLE_BYTES: usize = 50;

pub(super) fn parse(bytes: &[u8]) -> Result<Triangles, String> {
    // A binary header may begin with "solid" too; the length of the file distinguishes the two.
    let body = bytes.get(HEADER_BYTES + 4..);
    if let (Some(count), Some(body)) = (u32_at(bytes, HEADER_BYTES), body)
        && body.len() == (count as usize).saturating_mul(TRIANGLE_BYTES)
    {
        return Ok(binary(body));
    }
    if bytes.trim_ascii_start().starts_with(b"solid") {
        return text(&String::from_utf8_lossy(bytes));
    }
    Err(format!("{} bytes that are neither text STL nor binary STL of that length", bytes.len()))
}

fn binary(body: &[u8]) -> Triangles {
    let mut mesh = Triangles::default();
    for record in body.chunks_exact(TRIANGLE_BYTES) {
        let number = |place: usize| {
            f64::from(f32::from_bits(u32_at(record, 12 + 4 * place).unwrap_or_default()))
        };
        let corner = |first: usize| [number(first), number(first + 1), number(first + 2)];
        mesh.push([corner(0), corner(3), corner(6)]);
    }
    mesh
}

fn u32_at(bytes: &[u8], start: usize) -> Option<u32> {
    let four = bytes.get(start..start + 4)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}

fn text(text: &str) -> Result<Triangles, String> {
    let mut mesh = Triangles::default();
    let mut corners = Vec::with_capacity(3);
    let mut ended = false;
    for (line, words) in (1..).zip(text.lines()) {
        let mut words = words.split_whitespace();
        match words.next() {
            Some("vertex") => {
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                let corner = numbers.try_into();
                corners.push(corner.map_err(|_| format!("line {line}: a vertex needs 3 numbers"))?);
            }
            Some("endfacet") => {
                let facet = std::mem::take(&mut corners);
                let three = <[[f64; 3]; 3]>::try_from(facet)
                    .map_err(|all| format!("line {line}: a facet with {} corners", all.len()))?;
                mesh.push(three);
            }
            Some("endsolid") => ended = true,
            _ => {}
        }
    }
    if ended { Ok(mesh) } else { Err("cut off: no endsolid".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners that f32 holds exactly.
    const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.25, -1.0]];

    fn as_binary() -> Vec<u8> {
        let mut bytes = vec![b' '; HEADER_BYTES];
        bytes[..5].copy_from_slice(b"solid");
        bytes.extend(1_u32.to_le_bytes());
        bytes.extend([0; 12]);
        bytes.extend(CORNERS.iter().flatten().flat_map(|number| number.to_le_bytes()));
        bytes.extend([0; 2]);
        bytes
    }

    fn as_text() -> String {
        let corners = CORNERS.map(|[x, y, z]| format!("   vertex {x} {y} {z:e}\n")).concat();
        format!(
            "solid a\n facet normal 0 0 1\n  outer loop\n{corners}  endloop\n endfacet\nendsolid a\n"
        )
    }

    #[test]
    fn binary_and_text_hold_the_same_triangle() {
        let mesh = parse(&as_binary()).unwrap();
        let vertices = CORNERS.map(|corner| corner.map(f64::from)).to_vec();
        assert_eq!(mesh, Triangles { vertices, triangles: vec![[0, 1, 2]] });
        assert_eq!(parse(as_text().as_bytes()).unwrap(), mesh);
    }

    #[test]
    fn a_file_cut_anywhere_is_refused() {
        for whole in [as_binary(), as_text().into_bytes()] {
            // The text ends with the name of the solid, which may be missing.
            let needed = whole.len() - 3;
            for length in 0..needed {
                assert!(parse(&whole[..length]).is_err(), "accepted {length} bytes");
            }
        }
    }
}
