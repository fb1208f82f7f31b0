//! `twin export meshcat` and `twin export viser`: a recording for the stock viewers.

use std::path::PathBuf;

use clap::Args;
use twin_console::replay;

use super::End;
use super::viewers::default_folder;

#[derive(Args)]
pub(super) struct MeshcatArgs {
    /// A recording of `twin fly --record` or of a failed test.
    recording: PathBuf,
    /// The page [default: beside the recording, with the extension meshcat.html].
    #[arg(long, short, value_name = "FILE.html")]
    output: Option<PathBuf>,
    /// Folder of the stock viewers [default: where `twin viewers fetch` puts them].
    #[arg(long, value_name = "DIR")]
    viewer_dir: Option<PathBuf>,
}

#[derive(Args)]
pub(super) struct ViserArgs {
    /// A recording of `twin fly --record` or of a failed test.
    recording: PathBuf,
    /// The file; with the extension html, a page that needs no viser [default: beside the recording, with the extension viser].
    #[arg(long, short, value_name = "FILE.viser|FILE.html")]
    output: Option<PathBuf>,
    /// Folder of the stock viewers, for a page [default: where `twin viewers fetch` puts them].
    #[arg(long, value_name = "DIR")]
    viewer_dir: Option<PathBuf>,
}

pub(super) fn meshcat(args: &MeshcatArgs) -> anyhow::Result<End> {
    let MeshcatArgs { recording, output, viewer_dir } = args;
    let page = output.clone().unwrap_or_else(|| recording.with_extension("meshcat.html"));
    let viewers = viewer_dir.clone().or_else(default_folder);
    replay::export_meshcat(recording, &page, viewers.as_deref())?;
    println!("{}", page.display());
    Ok(End::Passed)
}

pub(super) fn viser(args: &ViserArgs) -> anyhow::Result<End> {
    let ViserArgs { recording, output, viewer_dir } = args;
    let file = output.clone().unwrap_or_else(|| recording.with_extension("viser"));
    let viewers = viewer_dir.clone().or_else(default_folder);
    replay::export_viser(recording, &file, viewers.as_deref())?;
    println!("{}", file.display());
    Ok(End::Passed)
}
