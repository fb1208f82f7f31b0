//! Resolves `package://`, `file://` and relative references to meshes.

use std::path::{Path, PathBuf};

use roxmltree::Document;

/// Longest URDF whose meshes are looked up, bytes.
const LONGEST_URDF: u64 = 64 << 20;

/// Folders of the packages in `package://name/…`, by package name; earlier entries win.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Packages(pub Vec<(String, PathBuf)>);

impl Packages {
    /// The file that `reference` in the URDF `urdf` names, or the defect and its remedy.
    pub(super) fn resolve(
        &self,
        reference: &str,
        urdf: &Path,
    ) -> Result<PathBuf, (String, String)> {
        let package =
            reference.strip_prefix("package://").or_else(|| reference.strip_prefix("model://"));
        if let Some(path) = package {
            let (name, rest) = path.split_once('/').unwrap_or((path, ""));
            return self
                .0
                .iter()
                .find(|(known, _)| known == name)
                .map(|(_, folder)| folder.join(rest))
                .ok_or_else(|| self.unknown(name));
        }
        if let Some(path) = reference.strip_prefix("file://") {
            return Ok(PathBuf::from(path));
        }
        if let Some((scheme, _)) = reference.split_once("://") {
            let remedy = "use a path relative to the URDF, file:// or package://".into();
            return Err((format!("{scheme}:// is not read"), remedy));
        }
        Ok(urdf.parent().unwrap_or(Path::new("")).join(reference))
    }

    /// The URDF at `urdf` and its meshes, as far as they can be found. A file that is no URDF stands alone.
    pub fn files(&self, urdf: &Path) -> Vec<PathBuf> {
        let mut files = vec![urdf.to_owned()];
        let short = std::fs::metadata(urdf).is_ok_and(|f| f.is_file() && f.len() <= LONGEST_URDF);
        let text = short.then(|| std::fs::read_to_string(urdf).ok()).flatten().unwrap_or_default();
        let Ok(document) = Document::parse(&text) else { return files };
        let meshes = document.descendants().filter(|node| node.has_tag_name("mesh"));
        let names = meshes.filter_map(|node| node.attribute("filename"));
        files.extend(names.filter_map(|name| self.resolve(name, urdf).ok()));
        files
    }

    fn unknown(&self, name: &str) -> (String, String) {
        let known: Vec<&str> = self.0.iter().map(|(known, _)| known.as_str()).collect();
        let known = if known.is_empty() { "none".into() } else { known.join(", ") };
        let remedy = format!("add {name:?} to the vehicle's packages (known: {known})");
        (format!("package {name:?} is not known"), remedy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_lead_where_ros_says() {
        let packages = Packages(vec![("arm".into(), "share/arm".into())]);
        let resolve = |reference| packages.resolve(reference, Path::new("urdf/vehicle.urdf"));
        assert_eq!(resolve("package://arm/m/a.stl"), Ok("share/arm/m/a.stl".into()));
        assert_eq!(resolve("model://arm/a.stl"), Ok("share/arm/a.stl".into()));
        assert_eq!(resolve("file:///opt/a.stl"), Ok("/opt/a.stl".into()));
        assert_eq!(resolve("meshes/a.stl"), Ok("urdf/meshes/a.stl".into()));
        assert!(resolve("package://leg/a.stl").unwrap_err().1.contains("known: arm"));
        assert!(resolve("https://somewhere/a.stl").is_err());
    }
}
