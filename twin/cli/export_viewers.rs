//! `twin export meshcat` and `twin export viser`: a recording for the stock viewers.

use std::path::PathBuf;

use clap::Args;
use twin_console::replay;
use twin_console::server::viewers::{MESHCAT, VISER};

use super::export_html::hand_over;
use super::viewers::default_folder;
use super::{End, Overwrite};

#[derive(Args)]
pub(super) struct MeshcatArgs {
    /// A recording of `twin fly --record` or of a failed test.
    recording: PathBuf,
    /// The page, in an existing folder; `-` is stdout [default: beside the recording, with the extension meshcat.html].
    #[arg(long, short, value_name = "FILE.html")]
    output: Option<PathBuf>,
    /// Folder of the stock viewers [default: where `twin viewers fetch` puts them].
    #[arg(long, value_name = "DIR")]
    viewer_dir: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

#[derive(Args)]
pub(super) struct ViserArgs {
    /// A recording of `twin fly --record` or of a failed test.
    recording: PathBuf,
    /// The file, in an existing folder; with the extension html, a page that needs no viser; `-` is stdout [default: beside the
    /// recording, with the extension viser].
    #[arg(long, short, value_name = "FILE.viser|FILE.html")]
    output: Option<PathBuf>,
    /// Folder of the stock viewers, for a page [default: where `twin viewers fetch` puts them].
    #[arg(long, value_name = "DIR")]
    viewer_dir: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

pub(super) fn meshcat(args: &MeshcatArgs) -> anyhow::Result<End> {
    let MeshcatArgs { recording, output, viewer_dir, overwrite } = args;
    let outputs = overwrite.outputs();
    let viewers = viewer_dir.clone().or_else(default_folder);
    outputs.protect([recording]);
    outputs.protect(viewers.iter().flat_map(|folder| MESHCAT.paths(folder)));
    let page = output.clone().unwrap_or_else(|| recording.with_extension("meshcat.html"));
    let output = outputs.reserve(&page, "--output")?;
    hand_over(output, replay::export_meshcat(recording, viewers.as_deref())?.as_bytes())?;
    Ok(End::Passed)
}

pub(super) fn viser(args: &ViserArgs) -> anyhow::Result<End> {
    let ViserArgs { recording, output, viewer_dir, overwrite } = args;
    let outputs = overwrite.outputs();
    let viewers = viewer_dir.clone().or_else(default_folder);
    outputs.protect([recording]);
    outputs.protect(viewers.iter().flat_map(|folder| VISER.paths(folder)));
    let file = output.clone().unwrap_or_else(|| recording.with_extension("viser"));
    let output = outputs.reserve(&file, "--output")?;
    let is_page = file.extension().is_some_and(|ending| ending == "html");
    hand_over(output, &replay::export_viser(recording, is_page, viewers.as_deref())?)?;
    Ok(End::Passed)
}
