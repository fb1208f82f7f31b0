//! The stock viewers of two other projects, MeshCat and viser, as clients of the same flight.
//!
//! In: the messages and rows that the hub gives to every client. Out: the wire formats of the stock viewers. Their controls
//! become the same [`crate::server::protocol::ClientMessage`]s that the console sends, and pass the same checks. The viewers are
//! no part of this program: `twin viewers fetch` downloads the builds pinned here. [`export`] writes a recorded flight in the
//! same formats.

mod drawing;
mod trail;
mod forces;
mod attitude_marks;
mod layers;
mod controls;
mod chart;
mod pack;
mod viewer_state;
mod meshcat_command;
mod meshcat_object;
pub(super) mod meshcat;
mod viser_frame;
mod viser_move;
mod viser_panel;
mod viser_label;
mod viser_scene;
pub(super) mod viser;
pub(super) mod pages;
mod recorded_drawing;
mod meshcat_animation;
mod viser_recording;
pub mod export;

use std::path::{Path, PathBuf};

#[cfg(test)]
pub(super) mod fixture;

/// A pinned wheel of the Python package index; the server serves a few of its files.
#[derive(Clone, Copy, Debug)]
pub struct Wheel {
    /// Name of the package.
    pub package: &'static str,
    /// Its version.
    pub version: &'static str,
    /// Python version, ABI and platform of the wheel, as in its name.
    pub tag: &'static str,
    /// SHA-256 of the wheel, hexadecimal.
    pub sha256: &'static str,
    /// Files that are kept: path in the wheel and name in [`Wheel::folder`]. The first is the page; the licences are among them.
    pub files: &'static [(&'static str, &'static str)],
}

impl Wheel {
    /// Name of the wheel's file.
    pub fn file_name(&self) -> String {
        format!("{}-{}-{}.whl", self.package, self.version, self.tag)
    }

    /// Flags of pip that select this wheel on any machine.
    pub fn pip_flags(&self) -> Vec<String> {
        let parts: Vec<&str> = self.tag.split('-').collect();
        let [python, abi, platform] = parts[..] else { return Vec::new() };
        // The tag "3" is a wheel for every Python 3. pip reads "3" as 3.0.0 and refuses wheels that require 3.8 or later.
        let version = Some(&python[2..]).filter(|version| *version != "3").unwrap_or("312");
        let flags = [("--implementation", &python[..2]), ("--python-version", version)];
        let flags = flags.into_iter().chain([("--abi", abi), ("--platform", platform)]);
        flags.flat_map(|(flag, value)| [flag.to_owned(), value.to_owned()]).collect()
    }

    /// Paths of the kept files below `viewers`, the folder of all viewers.
    pub fn paths(&self, viewers: &Path) -> Vec<PathBuf> {
        let folder = viewers.join(self.folder());
        self.files.iter().map(|(_, name)| folder.join(name)).collect()
    }

    /// Folder of the kept files, below the folder of all viewers.
    pub fn folder(&self) -> String {
        format!("{}-{}", self.package, self.version)
    }
}

/// The viewer of meshcat-python (three.js r132).
pub const MESHCAT: Wheel = Wheel {
    package: "meshcat",
    version: "0.3.2",
    tag: "py3-none-any",
    sha256: "cba0465d0e29658c48bb65d27f5c8e04ff0a1ac8ce916d65621146c06258a1c7",
    files: &[
        ("meshcat/viewer/dist/index.html", "index.html"),
        ("meshcat/viewer/dist/main.min.js", "main.min.js"),
        ("meshcat/viewer/LICENSE", "LICENSE"),
        ("meshcat/viewer/dist/main.min.js.LICENSE.txt", "main.min.js.LICENSE.txt"),
        (
            "meshcat/viewer/dist/main.min.js.THIRD_PARTY_LICENSES.json",
            "main.min.js.THIRD_PARTY_LICENSES.json",
        ),
    ],
};

/// The current MeshCat viewer (three.js r176), which Drake ships with its own page.
pub const DRAKE: Wheel = Wheel {
    package: "drake",
    version: "1.51.1",
    tag: "cp311-cp311-manylinux_2_34_x86_64",
    sha256: "ce2a9df43194e447a85556f96593d7de79891eec16bf48b406c5ce5d1de93270",
    files: &[
        ("pydrake/share/drake/geometry/meshcat.html", "index.html"),
        ("pydrake/share/drake/geometry/meshcat.js", "meshcat.js"),
        ("pydrake/doc/meshcat/LICENSE", "LICENSE"),
        (
            "pydrake/doc/meshcat/main.min.js.THIRD_PARTY_LICENSES.json",
            "main.min.js.THIRD_PARTY_LICENSES.json",
        ),
        ("pydrake/doc/drake/LICENSE.TXT", "LICENSE.drake.txt"),
    ],
};

/// The client of viser. Its metadata name the MIT licence and its files contain the text of Apache-2.0; both are kept.
pub const VISER: Wheel = Wheel {
    package: "viser",
    version: "1.1.1",
    tag: "py3-none-any",
    sha256: "f528877553c56e1c01d43b861a1434920a2e7ba4fdc7b2e7ff03721e3c3f5b3d",
    files: &[
        ("viser/client/build/index.html", "index.html"),
        ("viser-1.1.1.dist-info/licenses/LICENSE", "LICENSE"),
        ("viser-1.1.1.dist-info/METADATA", "METADATA"),
    ],
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pip_is_asked_for_the_pinned_wheel_on_every_machine() {
        let flags = |wheel: Wheel| wheel.pip_flags().join(" ");
        assert_eq!(
            flags(DRAKE),
            "--implementation cp --python-version 311 --abi cp311 --platform manylinux_2_34_x86_64"
        );
        assert_eq!(
            flags(VISER),
            "--implementation py --python-version 312 --abi none --platform any"
        );
    }
}
