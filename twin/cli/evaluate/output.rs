//! Files that a table is written to.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use twin_lab::evaluate::{Sheet, pictures_page};
use twin_record::output::{self, Outputs, note};
use twin_scenario::Scenario;

use crate::cli::{Overwrite, place};

/// The flags of every command that makes a table.
#[derive(Args)]
pub(super) struct Output {
    /// Print one JSON object instead of a table.
    #[arg(long)]
    pub(super) json: bool,
    /// Write the table as CSV; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write a page with pictures; it opens offline; `-` is stdout.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// The files that flights of the scenarios `files` read: each scenario, its models with their meshes, its weights.
pub(super) fn inputs_of<'a>(files: impl IntoIterator<Item = &'a PathBuf>) -> Vec<PathBuf> {
    let files: BTreeSet<&PathBuf> = files.into_iter().collect();
    let inputs = |file: &&PathBuf| match Scenario::load(file, &[]) {
        Ok(scenario) => scenario.input_files(),
        // Its flight says what is wrong with it.
        Err(_) => vec![(*file).clone()],
    };
    files.iter().flat_map(inputs).collect()
}

/// The places of the files, reserved before the table is computed.
pub(super) struct Places {
    pub(super) outputs: Outputs,
    csv: Option<output::Output>,
    html: Option<output::Output>,
}

impl Output {
    /// Reserves the places of the files; the command reads `inputs`.
    pub(super) fn reserve(
        &self,
        inputs: impl IntoIterator<Item = PathBuf>,
    ) -> anyhow::Result<Places> {
        let outputs = self.overwrite.outputs_beside(inputs, self.json)?;
        let csv = place(&outputs, self.csv.as_deref(), "--csv")?;
        let html = place(&outputs, self.html.as_deref(), "--html")?;
        Ok(Places { outputs, csv, html })
    }
}

impl Places {
    /// Writes the files that the flags name; calls `page` only if one of them is a page. Returns the outputs of the run.
    pub(super) fn write(
        self,
        sheet: &Sheet,
        page: impl FnOnce() -> anyhow::Result<String>,
    ) -> anyhow::Result<Outputs> {
        if let Some(output) = self.csv {
            write(output, sheet.csv().as_bytes())?;
        }
        if let Some(output) = self.html {
            write(output, page()?.as_bytes())?;
        }
        Ok(self.outputs)
    }

    /// Writes the files; the page has `title`, the table, and `pictures` below it. Returns the outputs of the run.
    pub(super) fn write_pictures(
        self,
        title: &str,
        sheet: &Sheet,
        pictures: impl FnOnce() -> anyhow::Result<String>,
    ) -> anyhow::Result<Outputs> {
        self.write(sheet, || {
            let body = sheet.html() + &pictures()?;
            Ok(pictures_page(title, &body, &super::command()))
        })
    }
}

/// Writes an output and says where it is.
pub(super) fn write(output: output::Output, bytes: &[u8]) -> anyhow::Result<()> {
    let path = output.path().display().to_string();
    output.write(bytes)?;
    note(format_args!("wrote {path}"));
    Ok(())
}
