//! Files that a table is written to.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use twin_lab::evaluate::{Sheet, pictures_page};

/// The flags of every command that makes a table.
#[derive(Args)]
pub(super) struct Output {
    /// Print one JSON object instead of a table.
    #[arg(long)]
    pub(super) json: bool,
    /// Write the table as CSV.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write a page with pictures; it opens offline.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

impl Output {
    /// Writes the files that the flags name; calls `page` only if one of them is a page.
    pub(super) fn write(
        &self,
        sheet: &Sheet,
        page: impl FnOnce() -> anyhow::Result<String>,
    ) -> anyhow::Result<()> {
        if let Some(path) = &self.csv {
            write(path, sheet.csv().as_bytes())?;
            eprintln!("wrote {}", path.display());
        }
        if let Some(path) = &self.html {
            write(path, page()?.as_bytes())?;
            eprintln!("wrote {}", path.display());
        }
        Ok(())
    }

    /// Writes the files; the page has `title`, the table, and `pictures` below it.
    pub(super) fn write_pictures(
        &self,
        title: &str,
        sheet: &Sheet,
        pictures: impl FnOnce() -> anyhow::Result<String>,
    ) -> anyhow::Result<()> {
        self.write(sheet, || {
            let body = sheet.html() + &pictures()?;
            Ok(pictures_page(title, &body, &super::command()))
        })
    }
}

/// Writes a file, and makes its folder if it is missing.
pub(super) fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot be made", folder.display()))?;
    }
    std::fs::write(path, bytes).with_context(|| format!("{}: cannot be written", path.display()))
}
