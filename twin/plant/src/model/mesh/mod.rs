//! Triangle meshes from STL, OBJ and COLLADA files. The readers are our own, because the published ones panic on broken files.

mod stl;
mod obj;
mod collada;

use std::cell::Cell;
use std::path::Path;

use super::Shape;
use twin_input::budget::{ALL_MESH_BYTES, MESH_BYTES, TRIANGLES};
use twin_input::{Excess, file};

/// Defect and remedy.
pub(super) type Finding = (String, String);

/// A mesh with the coordinates of its file.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Triangles {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Triangles {
    /// The shape with each axis multiplied by its scale. The triangles of a mirrored mesh are reversed, so their normals still point
    /// outward.
    pub(super) fn scaled(mut self, scale: [f64; 3]) -> Shape {
        for vertex in &mut self.vertices {
            *vertex = [0, 1, 2].map(|axis| vertex[axis] * scale[axis]);
        }
        if scale.iter().product::<f64>() < 0.0 {
            self.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        Shape::Mesh { vertices: self.vertices, triangles: self.triangles }
    }

    fn push(&mut self, corners: [[f64; 3]; 3]) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }
}

/// Reads the triangles of the file `path`; its extension selects the format. Adds its length to `bytes`, the bytes of all meshes.
pub(super) fn read(path: &Path, bytes: &Cell<u64>) -> Result<Triangles, Finding> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or("");
    let reader = match extension.to_ascii_lowercase().as_str() {
        "stl" => stl::parse,
        "obj" => obj::parse,
        "dae" => collada::parse,
        _ => {
            let remedy = "allowed: .stl, .obj, .dae; convert the mesh".into();
            return Err((format!("unknown extension {extension:?}"), remedy));
        }
    };
    let content = file::read(path, MESH_BYTES).map_err(|error| {
        let remedy = "check the path, or name its package in the vehicle's packages".into();
        (format!("cannot read {}: {error}", path.display()), remedy)
    })?;
    bytes.set(bytes.get().saturating_add(content.len() as u64));
    let refused = |excess: Excess| (format!("{excess}"), excess.limit.remedy.to_owned());
    ALL_MESH_BYTES.check(bytes.get()).map_err(refused)?;
    let mesh = reader(&content).map_err(|found| (found, "export the mesh again".to_owned()))?;
    TRIANGLES.check_count(mesh.triangles.len()).map_err(refused)?;
    if mesh.triangles.is_empty() {
        return Err(("no triangles".into(), "export the mesh with its faces".into()));
    }
    if mesh.vertices.iter().flatten().any(|coordinate| !coordinate.is_finite()) {
        return Err(("a corner is not finite".into(), "export the mesh again".into()));
    }
    Ok(mesh)
}
