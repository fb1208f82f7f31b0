//! A cache of flight reports: a table that was interrupted continues where it stopped.
//!
//! The key of a report is a hash of everything that decides a flight: the program itself, the scenario with all its keys, the
//! vehicle's URDF and the bytes of the weights. A stale report can therefore never be found.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::collect::sha256_of;
use super::settings::PredictorKind;
use super::{Report, Scenario};
use twin_input::budget::REPORT_BYTES;
use twin_record::output::{make_folder, replace};

/// Reports of flights, by the hash of the flight.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
    program: String,
}

impl Cache {
    /// A cache in `folder`, which is created, for the running program.
    ///
    /// # Errors
    /// An I/O error if the folder cannot be created, or the program cannot read its own file.
    pub fn open(folder: &Path) -> std::io::Result<Self> {
        make_folder(folder, "--cache")?;
        let program = sha256_of(&std::env::current_exe()?)
            .map_err(|error| std::io::Error::other(error.to_string()))?;
        Ok(Self { folder: folder.to_owned(), program })
    }

    /// The report of this flight, if the cache has it and can read it.
    pub fn find(&self, scenario: &Scenario) -> Option<Report> {
        let text = twin_input::file::read_text(&self.place(scenario)?, REPORT_BYTES).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Stores the report of this flight. A failure to write is only logged.
    pub fn keep(&self, scenario: &Scenario, report: &Report) {
        let Some((place, text)) = self.place(scenario).zip(serde_json::to_string(report).ok())
        else {
            return;
        };
        if let Err(error) = replace(&place, text.as_bytes()) {
            tracing::warn!("the report is not cached: {error}");
        }
    }

    fn place(&self, scenario: &Scenario) -> Option<PathBuf> {
        let mut hash = Sha256::new();
        hash.update(self.program.as_bytes());
        hash.update(scenario.name.as_bytes());
        hash.update(toml::to_string(&scenario.settings).ok()?);
        hash.update(scenario.urdf_text().ok()?);
        let predictor = &scenario.settings.predictor;
        // Weights that are built into the program are part of its hash.
        let trained = matches!(predictor.kind, PredictorKind::Fdt | PredictorKind::Trained);
        if trained && predictor.weights != "default" {
            hash.update(sha256_of(&scenario.folder().join(&predictor.weights)).ok()?);
        }
        let name = hash.finalize().iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        });
        Some(self.folder.join(format!("{name}.json")))
    }
}
