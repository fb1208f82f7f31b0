//! A golden run: a stored flight that later flights of the same scenario must repeat within tolerances.
//!
//! In: the `[golden]` of a scenario, the stored file, then every [`Tick`]. Out: the first divergence with time, channel and both
//! values; or the text of a new golden run. State: the flight so far, or the position in the stored flight.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::checks::{CheckError, Violation, signal, signal_names};
use twin_core::notation::TICK_S;
use twin_core::tick::Tick;
use twin_input::budget::REPORT_BYTES;

/// The golden run of a scenario, and the tolerances of the comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoldenSettings {
    /// The stored flight (CSV), relative to the scenario file.
    pub file: String,
    /// Time between two lines of the file, s.
    #[serde(default = "tenth")]
    pub every_s: f64,
    /// Largest allowed difference of each compared signal, in its unit.
    pub tolerance: BTreeMap<String, f64>,
}

fn tenth() -> f64 {
    0.1
}

/// Refuses tolerances that would compare nothing.
pub(super) fn validate(golden: &GoldenSettings) -> Result<(), CheckError> {
    let unknown = golden.tolerance.keys().find(|name| !signal_names().any(|known| known == *name));
    let reason = match unknown {
        Some(name) => {
            let allowed = signal_names().collect::<Vec<_>>().join(", ");
            format!("found {name:?}, expected some of {allowed}")
        }
        None if golden.tolerance.is_empty() => {
            "no signal is named, so nothing is compared".to_owned()
        }
        None => return Ok(()),
    };
    Err(CheckError { key: "golden.tolerance".to_owned(), reason })
}

/// The compared signals at a tick, in the order of the tolerances; NaN if unknown.
fn values(settings: &GoldenSettings, tick: &Tick) -> Vec<f64> {
    let names = settings.tolerance.keys();
    names.map(|name| signal(name, tick).unwrap_or(f64::NAN)).collect()
}

/// Whether the file has a line for this tick.
fn has_row(settings: &GoldenSettings, tick: &Tick) -> bool {
    let ticks = (settings.every_s / TICK_S).round().max(1.0) as u64;
    (tick.index + 1).is_multiple_of(ticks)
}

/// Writes a golden run.
pub struct GoldenWriter {
    settings: GoldenSettings,
    text: String,
}

impl GoldenWriter {
    /// A writer for a flight under `settings`.
    pub fn new(settings: &GoldenSettings) -> Self {
        let mut text = "t_s".to_owned();
        for name in settings.tolerance.keys() {
            let _ = write!(text, ",{name}");
        }
        Self { settings: settings.clone(), text: text + "\n" }
    }

    /// Adds a tick, if the file has a line for it.
    pub fn add(&mut self, tick: &Tick) {
        if has_row(&self.settings, tick) {
            let _ = write!(self.text, "{:.2}", tick.measurement.t_s);
            for value in values(&self.settings, tick) {
                let _ = write!(self.text, ",{value:.6}");
            }
            self.text.push('\n');
        }
    }

    /// The golden run as text.
    pub fn finish(self) -> String {
        self.text
    }
}

/// Compares a flight with its golden run.
#[derive(Clone)]
pub(super) struct GoldenCheck {
    settings: GoldenSettings,
    rows: Vec<(f64, Vec<f64>)>,
    next: usize,
    last_s: f64,
    divergence: Option<Violation>,
}

impl GoldenCheck {
    /// Reads the golden run of a scenario in `folder`. An unreadable file counts as a divergence from the start.
    pub(super) fn new(settings: &GoldenSettings, folder: &Path) -> Self {
        let (rows, divergence) = match read(settings, &folder.join(&settings.file)) {
            Ok(rows) => (rows, None),
            Err(found) => (Vec::new(), Some(broken(settings, "", None, found, "", 0.0))),
        };
        Self { settings: settings.clone(), rows, next: 0, last_s: 0.0, divergence }
    }

    pub(super) fn add(&mut self, tick: &Tick) {
        let t_s = tick.measurement.t_s;
        self.last_s = t_s;
        if self.divergence.is_some() || !has_row(&self.settings, tick) {
            return;
        }
        let Some((stored_s, stored)) = self.rows.get(self.next) else { return };
        self.next += 1;
        if (stored_s - t_s).abs() > 0.5 * TICK_S {
            let (found, wanted) = (format!("a tick at {t_s:.2} s"), format!("{stored_s:.2} s"));
            self.divergence = Some(broken(&self.settings, "t_s", None, found, &wanted, t_s));
            return;
        }
        let tolerances = self.settings.tolerance.iter();
        let parted = tolerances.zip(values(&self.settings, tick)).zip(stored).find(
            |(((_, tolerance), value), stored)| {
                // Two NaN values are equal.
                let apart = (value - **stored).abs();
                !(apart <= **tolerance || (value.is_nan() && stored.is_nan()))
            },
        );
        self.divergence = parted.map(|(((name, tolerance), value), stored)| {
            let allowed = format!("{stored:.6} ± {tolerance}");
            broken(&self.settings, name, Some(value), format!("{value:.6}"), &allowed, t_s)
        });
    }

    /// The first divergence. A flight that ends at another time diverges at its end.
    pub(super) fn finish(self) -> Option<Violation> {
        if self.divergence.is_some() {
            return self.divergence;
        }
        let end_s = self.rows.last().map_or(0.0, |(t_s, _)| *t_s);
        let apart = (self.last_s - end_s).abs() > self.settings.every_s + 0.5 * TICK_S;
        apart.then(|| {
            let (found, wanted) =
                (format!("an end at {:.2} s", self.last_s), format!("{end_s:.2} s"));
            broken(&self.settings, "t_s", None, found, &wanted, self.last_s.min(end_s))
        })
    }
}

fn broken(
    settings: &GoldenSettings,
    channel: &str,
    value: Option<f64>,
    found: String,
    stored: &str,
    at_s: f64,
) -> Violation {
    let file = &settings.file;
    let allowed = if stored.is_empty() {
        format!("the flight stored in {file}; twin test --update stores one")
    } else {
        format!("{stored}, as in {file}")
    };
    let what = format!("golden run {channel}").trim_end().to_owned();
    Violation { name: "golden".to_owned(), what, value, found, allowed, at_s }
}

fn read(settings: &GoldenSettings, path: &Path) -> Result<Vec<(f64, Vec<f64>)>, String> {
    let text = twin_input::file::read_text(path, REPORT_BYTES).map_err(|error| {
        if error.is_absent() { format!("no file: {error}") } else { error.to_string() }
    })?;
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let columns: Vec<usize> = settings
        .tolerance
        .keys()
        .map(|name| {
            let place = header.iter().position(|column| column == name);
            place.ok_or_else(|| format!("no column {name:?} among {}", header.join(", ")))
        })
        .collect::<Result<_, String>>()?;
    let row = |(number, line): (usize, &str)| {
        let cells: Vec<f64> =
            line.split(',').map(str::parse).collect::<Result<_, _>>().map_err(|_| {
                format!("line {} does not consist of numbers: {line:?}", number + 2)
            })?;
        let at = |column: usize| {
            cells.get(column).copied().ok_or(format!("line {} is too short", number + 2))
        };
        let stored = columns.iter().map(|column| at(*column)).collect::<Result<Vec<_>, _>>()?;
        Ok::<_, String>((at(0)?, stored))
    };
    let rows = lines.enumerate().map(row).collect::<Result<Vec<_>, _>>()?;
    if rows.is_empty() { Err("the file has no line of values".to_owned()) } else { Ok(rows) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_record::fixture;

    fn settings(tolerance: f64) -> GoldenSettings {
        let tolerance = BTreeMap::from([("height_m".to_owned(), tolerance)]);
        GoldenSettings { file: "g.csv".to_owned(), every_s: 0.05, tolerance }
    }

    /// Sixty ticks at 1 m; from tick `from` on the height is raised by `by`.
    fn flight(ticks: u64, from: u64, by: f64) -> Vec<Tick> {
        (0..ticks)
            .map(|index| {
                let mut tick = fixture::tick(index);
                tick.index = index;
                tick.measurement.t_s = (index + 1) as f64 * TICK_S;
                if let Some(truth) = &mut tick.truth {
                    truth.chi[2] = if index >= from { 1.0 + by } else { 1.0 };
                }
                tick
            })
            .collect()
    }

    fn compared(stored: &[Tick], flown: &[Tick], tolerance: f64) -> Option<Violation> {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = GoldenWriter::new(&settings(tolerance));
        for tick in stored {
            writer.add(tick);
        }
        std::fs::write(folder.path().join("g.csv"), writer.finish()).unwrap();
        let mut check = GoldenCheck::new(&settings(tolerance), folder.path());
        for tick in flown {
            check.add(tick);
        }
        check.finish()
    }

    #[test]
    fn the_same_flight_does_not_diverge_and_neither_does_one_within_the_tolerance() {
        let stored = flight(60, 60, 0.0);
        assert_eq!(compared(&stored, &stored, 1e-6), None);
        assert_eq!(compared(&stored, &flight(60, 30, 0.004), 0.005), None);
    }

    #[test]
    fn the_first_divergence_is_told_with_time_channel_and_both_values() {
        let found = compared(&flight(60, 60, 0.0), &flight(60, 31, 0.25), 0.005).unwrap();
        assert_eq!((found.name.as_str(), found.what.as_str()), ("golden", "golden run height_m"));
        // The ticks from 31 on differ. The next line is that of tick 34, at 0.35 s.
        assert!((found.at_s - 0.35).abs() < 1e-9, "{found}");
        assert!(found.found == "1.250000" && found.allowed.starts_with("1.000000 ± 0.005"));
    }

    #[test]
    fn another_length_and_a_missing_file_are_divergences_too() {
        let stored = flight(60, 60, 0.0);
        let short = compared(&stored, &flight(40, 60, 0.0), 0.1).unwrap();
        assert!(short.to_string().contains("an end at 0.40 s"), "{short}");
        let check = GoldenCheck::new(&settings(0.1), Path::new("/absent"));
        let absent = check.finish().unwrap().to_string();
        assert!(absent.contains("no file") && absent.contains("--update"), "{absent}");
    }
}
