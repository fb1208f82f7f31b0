//! Files that Foxglove requests by address: the vehicle's URDF, and the meshes and pictures in its packages. The server reads no
//! other file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::server::hub::Hub;
use twin_input::budget::ASSET_BYTES;
use twin_scenario::VehicleFiles;

/// Address of the URDF of the vehicle in flight.
const URDF: &str = "package://twin/vehicle.urdf";

/// Extensions of the files to which a URDF refers.
const KINDS: [&str; 10] =
    ["urdf", "xacro", "stl", "obj", "mtl", "dae", "glb", "png", "jpg", "jpeg"];

/// Longest address that is accepted, bytes.
const LONGEST_ADDRESS: usize = 512;

/// Gives access to the files of the vehicle in flight.
#[derive(Clone)]
pub(super) struct Assets {
    hub: Arc<Hub>,
    vehicles: Arc<BTreeMap<String, VehicleFiles>>,
}

impl Assets {
    pub(super) fn new(hub: Arc<Hub>, vehicles: Arc<BTreeMap<String, VehicleFiles>>) -> Self {
        Self { hub, vehicles }
    }

    /// Reads the file at `address`; blocks while the disk works.
    ///
    /// # Errors
    /// A sentence if the file does not exist, is too large, or lies outside of the vehicle's packages.
    pub(super) fn read(&self, address: &str) -> Result<Vec<u8>, String> {
        let scenario = self.hub.published().state.scenario;
        let vehicle = self.vehicles.get(&scenario).ok_or_else(|| {
            "no assets: a recording that is mirrored has no vehicle of its own".to_owned()
        })?;
        let path = locate(address, vehicle)?;
        twin_input::file::read(&path, ASSET_BYTES)
            .map_err(|error| format!("cannot read {address}: {error}"))
    }
}

/// The path of the file at `address`. With all links resolved it lies inside the folder of its package.
fn locate(address: &str, vehicle: &VehicleFiles) -> Result<PathBuf, String> {
    if address == URDF {
        return Ok(vehicle.urdf.clone());
    }
    let names: Vec<&str> = vehicle.packages.iter().map(|(name, _)| name.as_str()).collect();
    let refused = || {
        let shown: String = address.chars().take(100).collect();
        format!(
            "no asset {shown:?}; allowed: {URDF} and the meshes and pictures of the packages {names:?} as package://NAME/PATH"
        )
    };
    let path = address.strip_prefix("package://").filter(|_| address.len() <= LONGEST_ADDRESS);
    let (name, path) = path.and_then(|path| path.split_once('/')).ok_or_else(refused)?;
    let (_, folder) =
        vehicle.packages.iter().find(|(known, _)| known == name).ok_or_else(refused)?;
    let kind = Path::new(path).extension().and_then(|kind| kind.to_str()).unwrap_or("");
    if !KINDS.contains(&kind.to_ascii_lowercase().as_str()) {
        return Err(refused());
    }
    let folder = folder.canonicalize().map_err(|_| refused())?;
    let file = folder.join(path).canonicalize().map_err(|_| refused())?;
    if file.starts_with(&folder) && file.is_file() { Ok(file) } else { Err(refused()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_meshes_inside_the_folder_of_a_package_are_found() {
        let temporary = tempfile::tempdir().expect("a folder");
        let root = temporary.path();
        let folder = root.join("meshes");
        std::fs::create_dir_all(folder.join("arm")).expect("a folder");
        for file in ["meshes/arm/link.STL", "meshes/notes.txt", "secret.stl"] {
            std::fs::write(root.join(file), "x").expect("a file");
        }
        #[cfg(unix)]
        std::os::unix::fs::symlink(root.join("secret.stl"), folder.join("out.stl"))
            .expect("a link");
        let vehicle = VehicleFiles {
            urdf: root.join("robot.urdf"),
            packages: vec![("robot".to_owned(), folder.clone())],
            joints: Vec::new(),
        };
        let found = locate("package://robot/arm/link.STL", &vehicle).expect("it is there");
        assert!(found.ends_with("meshes/arm/link.STL"));
        assert_eq!(locate(URDF, &vehicle), Ok(root.join("robot.urdf")));
        let absolute = format!("package://robot/{}", root.join("secret.stl").display());
        for refused in [
            "package://robot/../secret.stl",
            "package://robot/arm/../../secret.stl",
            "package://robot/out.stl",
            "package://robot/notes.txt",
            "package://robot/missing.stl",
            "package://robot/arm",
            "package://other/arm/link.STL",
            "package://robot",
            "file:///etc/passwd",
            "/etc/passwd",
            "",
            absolute.as_str(),
        ] {
            let error = locate(refused, &vehicle).expect_err(refused);
            assert!(error.contains("package://twin/vehicle.urdf"), "{refused}: {error}");
        }
    }
}
