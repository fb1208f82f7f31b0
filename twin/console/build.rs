//! Builds the console with npm and packs it into the library.
//!
//! Without the feature `web`, without npm, or with `TWIN_WEB=skip` the table of assets is empty, and the server shows a
//! plain status page. With `TWIN_WEB=require` the build fails if the console cannot be built.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::{Compression, write::GzEncoder};

type Failure = Box<dyn Error>;

fn main() -> Result<(), Failure> {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR")?).join("../..");
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    println!("cargo:rerun-if-env-changed=TWIN_WEB");
    println!("cargo:rerun-if-changed=build.rs");
    let wish = std::env::var("TWIN_WEB").unwrap_or_default();
    let web = root.join("web");
    let (console, replay) = if std::env::var_os("CARGO_FEATURE_WEB").is_none() || wish == "skip" {
        (String::new(), String::new())
    } else {
        watch(&web);
        match build_web(&web, &out) {
            Ok(tables) => tables,
            Err(error) if wish == "require" => return Err(error),
            Err(error) => {
                println!("cargo:warning=the console is not part of this build: {error}");
                // Cargo cannot see that npm was installed. This file never exists, so the next build runs this script again.
                println!("cargo:rerun-if-changed=../../web/.try-again");
                (String::new(), String::new())
            }
        }
    };
    let code = format!(
        "/// Path, media type, bytes, compressed with gzip.\npub(super) static ASSETS: &[(&str, &str, &[u8], bool)] = &[{console}];\n"
    );
    fs::write(out.join("assets.rs"), code)?;
    let code = format!(
        "/// Name and bytes, compressed with gzip.\nstatic REPLAY: &[(&str, &[u8])] = &[{replay}];\n"
    );
    fs::write(out.join("replay.rs"), code)?;
    Ok(())
}

fn watch(web: &Path) {
    for name in [
        "src",
        "public",
        "index.html",
        "replay.html",
        "package.json",
        "package-lock.json",
        "tsconfig.json",
        "vite.config.ts",
        "vite.replay.config.ts",
    ] {
        if web.join(name).exists() {
            println!("cargo:rerun-if-changed=../../web/{name}");
        }
    }
}

/// Builds both pages; returns the table of the console's files and the table of the replay page's parts.
fn build_web(web: &Path, out: &Path) -> Result<(String, String), Failure> {
    let console = build_console(web, out)?;
    let dist = out.join("replay");
    npm(web, &["run", "build:replay", "--", "--outDir", &dist.to_string_lossy(), "--emptyOutDir"])?;
    let mut replay = String::new();
    for name in ["replay.html", "replay.css", "replay.js"] {
        let file = compressed(&dist.join(name), &out.join("packed"))?;
        writeln!(replay, "({name:?}, include_bytes!({:?})),", file.to_string_lossy())?;
    }
    Ok((console, replay))
}

fn build_console(web: &Path, out: &Path) -> Result<String, Failure> {
    if !web.join("package.json").exists() {
        return Err("web/package.json is missing".into());
    }
    let lock = web.join("package-lock.json");
    let installed = web.join("node_modules/.package-lock.json");
    let age = |path: &Path| fs::metadata(path).and_then(|data| data.modified()).ok();
    if age(&installed).is_none() || age(&installed) < age(&lock) {
        npm(web, &["ci", "--no-audit", "--no-fund"])?;
    }
    let dist = out.join("dist");
    if dist.exists() {
        fs::remove_dir_all(&dist)?;
    }
    npm(web, &["run", "build", "--", "--outDir", &dist.to_string_lossy(), "--emptyOutDir"])?;
    let mut table = String::new();
    pack(&dist, &dist, &out.join("packed"), &mut table)?;
    if table.is_empty() { Err("npm run build left no files".into()) } else { Ok(table) }
}

fn npm(web: &Path, arguments: &[&str]) -> Result<(), Failure> {
    let program = if cfg!(windows) { "npm.cmd" } else { "npm" };
    let output = Command::new(program)
        .args(arguments)
        .current_dir(web)
        .output()
        .map_err(|error| format!("npm: {error}"))?;
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let last =
        said.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("no message").to_owned();
    Err(format!("npm {} failed: {last}", arguments.join(" ")).into())
}

/// Adds the files under `folder` to the table, in the order of their names.
fn pack(root: &Path, folder: &Path, packed: &Path, table: &mut String) -> Result<(), Failure> {
    let mut entries = fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    entries.sort_by_key(fs::DirEntry::file_name);
    fs::create_dir_all(packed)?;
    for entry in entries {
        let path = entry.path();
        if path.is_dir() {
            pack(root, &path, packed, table)?;
            continue;
        }
        let name = path.strip_prefix(root)?.to_string_lossy().replace('\\', "/");
        let (mime, compress) = media_type(&name);
        let mut file = path;
        if compress {
            file = compressed(&file, packed)?;
        }
        writeln!(
            table,
            "({name:?}, {mime:?}, include_bytes!({:?}), {compress}),",
            file.to_string_lossy()
        )?;
    }
    Ok(())
}

/// Compresses `file` with gzip into the folder `packed`; returns the path of the compressed file.
fn compressed(file: &Path, packed: &Path) -> Result<PathBuf, Failure> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let target = packed.join(format!("{name}.gz"));
    let mut encoder = GzEncoder::new(fs::File::create(&target)?, Compression::best());
    encoder.write_all(&fs::read(file)?)?;
    encoder.finish()?;
    Ok(target)
}

/// Media type of a file, and whether gzip makes it smaller.
fn media_type(name: &str) -> (&'static str, bool) {
    match name.rsplit_once('.').map_or("", |(_, extension)| extension) {
        "html" => ("text/html; charset=utf-8", true),
        "js" | "mjs" => ("text/javascript; charset=utf-8", true),
        "css" => ("text/css; charset=utf-8", true),
        "json" | "map" => ("application/json", true),
        "svg" => ("image/svg+xml", true),
        "png" => ("image/png", false),
        "ico" => ("image/x-icon", false),
        "woff2" => ("font/woff2", false),
        "wasm" => ("application/wasm", true),
        _ => ("application/octet-stream", false),
    }
}
