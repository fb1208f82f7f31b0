//! `twin viewers`: downloads the pinned builds of the stock viewers and keeps the files that the server needs.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail};
use clap::{Args, Subcommand};
use sha2::{Digest, Sha256};
use twin_console::server::viewers::{DRAKE, MESHCAT, VISER, Wheel};
use twin_input::budget::VIEWER_BYTES;
use twin_record::output::{install, make_folder, note};

use super::End;

#[derive(Args, Clone)]
pub(super) struct ViewersArgs {
    #[command(subcommand)]
    command: ViewersCommand,
}

#[derive(Subcommand, Clone)]
enum ViewersCommand {
    /// Download the pinned viewers with pip, check and unpack them.
    Fetch {
        /// Folder for the viewers [default: twin/viewers in the user's cache folder].
        #[arg(long, value_name = "DIR")]
        dir: Option<PathBuf>,
        /// Also fetch the current MeshCat from Drake's wheel (42 MB, of which 2 MB are kept); it is served at /drake/.
        #[arg(long)]
        drake: bool,
    },
}

/// Unpacks members of a zip file into the folder `wheel`: `python3 -c UNPACK FILE MEMBER…`.
const UNPACK: &str = "import sys, zipfile\n\
                      zipfile.ZipFile(sys.argv[1]).extractall('wheel', sys.argv[2:])";

/// `twin/viewers` in the user's cache folder; `None` if there is no such folder.
pub(super) fn default_folder() -> Option<PathBuf> {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let cache = set("XDG_CACHE_HOME")
        .or_else(|| set("HOME").map(|home| home.join(".cache")))
        .or_else(|| set("LOCALAPPDATA"))?;
    Some(cache.join("twin").join("viewers"))
}

pub(super) fn run(args: &ViewersArgs) -> anyhow::Result<End> {
    let ViewersCommand::Fetch { dir, drake } = &args.command;
    let folder = dir
        .clone()
        .or_else(default_folder)
        .context("found neither XDG_CACHE_HOME nor HOME; name a folder with --dir")?;
    for wheel in [MESHCAT, VISER].into_iter().chain(drake.then_some(DRAKE)) {
        let target = folder.join(wheel.folder());
        if wheel.files.iter().all(|(_, name)| target.join(name).is_file()) {
            note(format_args!(
                "{} {} is already in {}",
                wheel.package,
                wheel.version,
                target.display()
            ));
            continue;
        }
        fetch(&wheel, &folder).with_context(|| format!("{} {}", wheel.package, wheel.version))?;
        note(format_args!("{} {} is in {}", wheel.package, wheel.version, target.display()));
    }
    Ok(End::Passed)
}

/// Downloads a wheel, checks it and unpacks it in a temporary folder, then moves the files that are kept to `folder`.
fn fetch(wheel: &Wheel, folder: &Path) -> anyhow::Result<()> {
    let work = folder.join(format!(".{}.{}", wheel.folder(), std::process::id()));
    make_folder(&work, "--dir")?;
    let done = fetch_into(wheel, folder, &work);
    if let Err(error) = std::fs::remove_dir_all(&work) {
        note(format_args!("{} is left behind: {error}", work.display()));
    }
    done
}

fn fetch_into(wheel: &Wheel, folder: &Path, work: &Path) -> anyhow::Result<()> {
    note(format_args!("downloading {} {} with pip", wheel.package, wheel.version));
    let pinned = format!("{}=={}", wheel.package, wheel.version);
    let flags = ["--no-deps", "--only-binary=:all:", "--quiet", "--disable-pip-version-check"];
    let tags = wheel.pip_flags();
    let tags: Vec<&str> = tags.iter().map(String::as_str).collect();
    let download = ["-m", "pip", "download", "--dest", "."];
    python(&[&download, &flags[..], &tags, &[&pinned]].concat(), work)
        .context("pip could not download it; python3 with pip and a network are needed, once")?;
    let file = work.join(wheel.file_name());
    let bytes = twin_input::file::read(&file, VIEWER_BYTES)
        .with_context(|| format!("pip left no {}", file.display()))?;
    check(wheel, &bytes)?;
    // Only the files that are kept: a whole wheel takes up to 200 MB.
    let kept: Vec<&str> = wheel.files.iter().map(|(path, _)| *path).collect();
    python(&[&["-c", UNPACK, &wheel.file_name()], &kept[..]].concat(), work)
        .context("the wheel could not be unpacked")?;
    let target = folder.join(wheel.folder());
    make_folder(&target, "--dir")?;
    for (path, name) in wheel.files {
        install(&work.join("wheel").join(path), &target.join(name))?;
    }
    Ok(())
}

/// Refuses a wheel whose hash is not the pinned one.
fn check(wheel: &Wheel, bytes: &[u8]) -> anyhow::Result<()> {
    let found = Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        // Writing into a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    });
    if found != wheel.sha256 {
        bail!(
            "{} has sha256 {found}, expected {}; it was not unpacked",
            wheel.file_name(),
            wheel.sha256
        );
    }
    Ok(())
}

/// Runs python3 in `folder`; if it fails, its output becomes the error.
fn python(arguments: &[&str], folder: &Path) -> anyhow::Result<()> {
    let output = Command::new("python3")
        .args(arguments)
        .current_dir(folder)
        .output()
        .context("cannot run python3; install it, with pip")?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let last: Vec<&str> = said.trim().lines().rev().take(3).collect();
        bail!("python3 said: {}", last.into_iter().rev().collect::<Vec<_>>().join(" | "));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheel_of_another_hash_is_refused_with_both_hashes() {
        // The hash of "abc" in FIPS 180-4.
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let error = check(&MESHCAT, b"abc").unwrap_err().to_string();
        assert!(error.contains(abc) && error.contains(MESHCAT.sha256), "{error}");
        assert!(check(&Wheel { sha256: abc, ..MESHCAT }, b"abc").is_ok());
    }
}
