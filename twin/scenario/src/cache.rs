//! Reports of flights that were made before: a table that was interrupted goes on where it stopped.
//!
//! A report is found again by everything that decides a flight: the program itself, the scenario with all its keys, the vehicle's
//! URDF and the bytes of the weights. Nothing else may change it, so nothing stale can be found.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::collect::sha256_of;
use super::settings::PredictorKind;
use super::{Report, Scenario};

/// Reports by the hash of their flight.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
    program: String,
}

impl Cache {
    /// In `folder`, which is made; for the program that runs.
    ///
    /// # Errors
    /// If the folder cannot be made or the program cannot read itself.
    pub fn open(folder: &Path) -> std::io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let program = sha256_of(&std::env::current_exe()?)
            .map_err(|error| std::io::Error::other(error.to_string()))?;
        Ok(Self { folder: folder.to_owned(), program })
    }

    /// The report of this flight, if it was made before and can still be read.
    pub fn find(&self, scenario: &Scenario) -> Option<Report> {
        let text = std::fs::read_to_string(self.place(scenario)?).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Keeps the report of this flight; a cache that cannot be written to is no reason to stop.
    pub fn keep(&self, scenario: &Scenario, report: &Report) {
        let Some((place, text)) = self.place(scenario).zip(serde_json::to_string(report).ok())
        else {
            return;
        };
        let part = place.with_extension("part");
        let written = std::fs::write(&part, text).and_then(|()| std::fs::rename(&part, &place));
        if let Err(error) = written {
            tracing::warn!("{}: not kept: {error}", place.display());
        }
    }

    fn place(&self, scenario: &Scenario) -> Option<PathBuf> {
        let mut hash = Sha256::new();
        hash.update(self.program.as_bytes());
        hash.update(scenario.name.as_bytes());
        hash.update(toml::to_string(&scenario.settings).ok()?);
        hash.update(scenario.urdf_text().ok()?);
        let predictor = &scenario.settings.predictor;
        // Weights the program was built with are part of the program.
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
