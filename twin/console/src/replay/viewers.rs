//! Exports a recorded flight to the two stock viewers: as a MeshCat page, as a viser recording, or as a viser page.
//!
//! In: a [`Recording`], and for a page the viewer's own files. Out: the content of a file that needs no server. State: none.

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::{ReplayError, fill, json_part};
use crate::server::viewers::{MESHCAT, VISER, Wheel, export};
use twin_input::budget::VIEWER_BYTES;
use twin_input::interruption;
use twin_record::scene::Scene;
use twin_record::{Recording, RecordingError, read_recording};

/// Level of zstd. A flight is written once, so a small file matters more than a fast compression.
const COMPRESSION_LEVEL: i32 = 9;

/// The page that meshcat-python writes as its static page.
const MESHCAT_PAGE: &str = "<!doctype html>
<html lang=\"en\">
<head><meta charset=\"utf-8\"><title>/*title*/</title>
<style>body { margin: 0 } #meshcat-pane { width: 100vw; height: 100vh; overflow: hidden }</style></head>
<body><div id=\"meshcat-pane\"></div>
<script>/*viewer*/</script>
<script>
  const viewer = new MeshCat.Viewer(document.getElementById(\"meshcat-pane\"));
  globalThis.viewer = viewer;
  for (const command of [/*commands*/])
    viewer.handle_command_bytearray(Uint8Array.from(atob(command), (c) => c.charCodeAt(0)));
</script></body></html>
";

/// A page that plays the recording at `from` in MeshCat's viewer; `viewers` is the folder of the stock viewers.
///
/// # Errors
/// [`ReplayError`] if the recording is not usable, or the viewer is not there.
pub fn export_meshcat(from: &Path, viewers: Option<&Path>) -> Result<String, ReplayError> {
    let viewer = viewer_file(MESHCAT, "main.min.js", viewers)?;
    let recording = read_recording(from)?;
    let commands = export::meshcat(&scene(&recording)?, &recording.ticks);
    interruption::check().map_err(RecordingError::from)?;
    let commands: Vec<String> =
        commands.iter().map(|bytes| format!("\"{}\"", STANDARD.encode(bytes))).collect();
    let title = recording.metadata.get("scenario").map_or("flight", String::as_str);
    let title: String = title.chars().filter(|c| !matches!(c, '<' | '>' | '&')).collect();
    let parts = [
        ("/*title*/", title.as_str()),
        ("/*viewer*/", viewer.as_str()),
        ("/*commands*/", &commands.join(",")),
    ];
    fill(MESHCAT_PAGE, &parts).ok_or_else(|| unusable(MESHCAT, "main.min.js"))
}

/// The recording at `from` in viser's format: with `is_page` as a page with viser's client, else as a `.viser` file. `viewers` is the
/// folder of the stock viewers.
///
/// # Errors
/// [`ReplayError`] if the recording is not usable, or the viewer is not there.
pub fn export_viser(
    from: &Path,
    is_page: bool,
    viewers: Option<&Path>,
) -> Result<Vec<u8>, ReplayError> {
    let client = is_page.then(|| viewer_file(VISER, "index.html", viewers)).transpose()?;
    let recording = read_recording(from)?;
    let inner = export::viser(&scene(&recording)?, &recording.ticks);
    interruption::check().map_err(RecordingError::from)?;
    let mut bytes = (inner.len() as u64).to_le_bytes().to_vec();
    bytes.extend(zstd::bulk::compress(&inner, COMPRESSION_LEVEL)?);
    let Some(client) = client else { return Ok(bytes) };
    // viser's own `as_html` inserts the same script.
    let data = format!(
        "<script>window.__VISER_EMBED_DATA__=\"{}\";window.__VISER_EMBED_CONFIG__={{darkMode:false}};</script></head>",
        STANDARD.encode(bytes)
    );
    let page = fill(&client, &[("</head>", &data)]).ok_or_else(|| unusable(VISER, "index.html"))?;
    Ok(page.into_bytes())
}

fn scene(recording: &Recording) -> Result<Scene, ReplayError> {
    json_part(recording.attachments.get("scene.json"), "scene.json")
}

fn viewer_file(
    wheel: Wheel,
    name: &'static str,
    viewers: Option<&Path>,
) -> Result<String, ReplayError> {
    let folder = viewers.map(|folder| folder.join(wheel.folder()));
    let path = folder.unwrap_or_else(|| PathBuf::from(wheel.folder())).join(name);
    twin_input::file::read_text(&path, VIEWER_BYTES)
        .map_err(|error| ReplayError::NoViewer { path, why: error.to_string() })
}

fn unusable(wheel: Wheel, name: &str) -> ReplayError {
    let path = PathBuf::from(wheel.folder()).join(name);
    ReplayError::NoViewer { path, why: "it is not the pinned file".to_owned() }
}
