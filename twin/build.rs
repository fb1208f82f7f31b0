//! Passes the commit of the checkout to the program as `TWIN_GIT_ID`.

use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=twin/build.rs");
    if let Some(root) = std::env::var_os("CARGO_MANIFEST_DIR") {
        note_commit(&PathBuf::from(root));
    }
}

fn note_commit(root: &Path) {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    if let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) {
        println!("cargo:rustc-env=TWIN_GIT_ID={commit}");
    }
    // Git appends to this log at every commit, checkout and merge.
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        println!("cargo:rerun-if-changed={log}");
    }
}
