//! `twin test` and `twin diff` through the real program: the behaviour that a CI relies on.

mod commands;
mod faults;
mod flipped;
mod golden;
mod junit;
mod repeats;
mod replay;
mod sweeps;

use std::path::Path;
use std::process::{Command, Output};

use crate::folder;

fn twin(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_twin"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the program starts")
}

/// A folder of this test that is removed at its end.
struct Folder(folder::Folder);

impl Folder {
    fn new(name: &str) -> Self {
        Self(folder::Folder::new(name))
    }

    fn path(&self, name: &str) -> String {
        self.0.text(name)
    }

    /// A hover of a second with the additional checks `more`; its models are those of the repository.
    fn hover(&self, name: &str, more: &str) -> String {
        let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/aerial_manipulator.urdf");
        let text = format!(
            "title = \"{name}\"\n[vehicle]\nurdf = \"{}\"\n[payload]\nmass_kg = 0.0\n[task]\nkind = \"hover\"\n\
             start_position_m = [0.0, 0.0, 1.2]\nduration_s = 1.0\n{more}",
            urdf.display()
        );
        let path = self.path(&format!("{name}.toml"));
        std::fs::write(&path, text).expect("a temporary file");
        path
    }

    /// `twin test` with its evidence in this folder.
    fn test(&self, arguments: &[&str]) -> Output {
        let artifacts = self.path("failed");
        let mut all = vec!["test", "--artifacts", &artifacts];
        all.extend(arguments);
        twin(&all)
    }
}

const TOO_LOW: &str =
    "[[checks]]\nsignal = \"height_m\"\nstatistic = \"max\"\nfrom_s = 0.5\nmax = 1.0\n";
