//! Turns recordings into series: for each flight 24 input channels, 8 coordinates of the residual, and the ticks that are usable.
//!
//! In: recordings of this program or of real flights. Out: [`Dataset`] in physical units (m, rad, N, N m), oldest tick first. A
//! channel that a flight does not know is left out by name. So a bare quadrotor, or data with forces alone, gives fewer channels.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::LearnError;
use super::foreign;
use super::raw::Raw;
use twin_core::notation::{COORDINATE_NAMES, N};
use twin_core::tick::{Adaptation, Tick};
use twin_foreign::{OpenedFlight, recorded_nominal_inertia};
use twin_record::{Recording, read_recording};

/// Stems of the input channels in the order of the model: coordinates, rates, and the force that was applied in the previous tick.
pub const STEMS: [&str; 3] = ["chi", "chi_dot", "tau"];

/// One flight.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightSeries {
    /// Name of the file.
    pub name: String,
    /// `[channels][ticks]`: `chi_t`, `chi_dot_t`, `tau_{t-1}`; m and rad, m/s and rad/s, N and N m.
    pub inputs: Vec<Vec<f32>>,
    /// `[outputs][ticks]`: residual `r_t`, N and N m.
    pub outputs: Vec<Vec<f32>>,
    /// For each tick, whether its residual may be learned: it is known, the vehicle is in the air and out of contact, the adapter is
    /// not frozen, and there is no fault.
    pub usable: Vec<bool>,
}

impl FlightSeries {
    /// Number of ticks.
    pub fn ticks(&self) -> usize {
        self.usable.len()
    }
}

/// Flights with the same channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Dataset {
    /// Names of the inputs, such as `chi_dot.z`.
    pub channel_names: Vec<String>,
    /// Names of the outputs, such as `z`.
    pub output_names: Vec<String>,
    /// Diagonal of the `M_bar` that formed the residuals, one entry for each output, kg and kg m².
    pub nominal_inertia: Vec<f64>,
    /// The flights.
    pub flights: Vec<FlightSeries>,
    /// Channels that were left out because a flight does not know them.
    pub left_out: Vec<String>,
}

impl Dataset {
    /// Reads the flights in `paths`.
    ///
    /// # Errors
    /// [`LearnError`] if a file cannot be read, is cut off, holds a number that is not finite, or does not fit the other files.
    pub fn read(paths: &[PathBuf]) -> Result<Self, LearnError> {
        let raw: Vec<Raw> = paths.iter().map(|path| read_one(path)).collect::<Result<_, _>>()?;
        Self::join(&raw)
    }

    /// Keeps the channels that every flight knows.
    fn join(raw: &[Raw]) -> Result<Self, LearnError> {
        let first = raw.first().ok_or(LearnError::NoData)?;
        let names: Vec<String> = STEMS
            .iter()
            .flat_map(|stem| COORDINATE_NAMES.map(|row| format!("{stem}.{row}")))
            .collect();
        let known = |of: fn(&Raw) -> &Vec<Option<Vec<f64>>>, index: usize| {
            raw.iter().all(|flight| of(flight)[index].is_some())
        };
        let inputs: Vec<usize> = (0..names.len()).filter(|i| known(|r| &r.inputs, *i)).collect();
        let outputs: Vec<usize> = (0..N).filter(|i| known(|r| &r.outputs, *i)).collect();
        if inputs.is_empty() || outputs.is_empty() {
            return Err(LearnError::NothingKnown);
        }
        let of_outputs = |all: &[f64]| outputs.iter().map(|row| all[*row]).collect::<Vec<f64>>();
        let nominal_inertia = of_outputs(&first.nominal_inertia);
        for flight in raw {
            let found = of_outputs(&flight.nominal_inertia);
            if found != nominal_inertia {
                let path = flight.path.clone();
                return Err(LearnError::Inertia { path, found, expected: nominal_inertia });
            }
        }
        let missing_input = names.iter().enumerate().filter(|(i, _)| !inputs.contains(i));
        let missing_output =
            COORDINATE_NAMES.iter().enumerate().filter(|(i, _)| !outputs.contains(i));
        let left_out = missing_input
            .map(|(_, name)| name.clone())
            .chain(missing_output.map(|(_, row)| format!("r.{row}")))
            .collect();
        let mut set = Self {
            channel_names: inputs.iter().map(|i| names[*i].clone()).collect(),
            output_names: outputs.iter().map(|i| COORDINATE_NAMES[*i].to_owned()).collect(),
            nominal_inertia,
            flights: Vec::new(),
            left_out,
        };
        for flight in raw {
            let series = set.series(flight, &inputs, &outputs)?;
            set.flights.push(series);
        }
        Ok(set)
    }

    fn series(
        &self,
        raw: &Raw,
        inputs: &[usize],
        outputs: &[usize],
    ) -> Result<FlightSeries, LearnError> {
        let pick = |all: &[Option<Vec<f64>>], which: &[usize], names: &[String], stem: &str| {
            which
                .iter()
                .zip(names)
                .map(|(index, name)| {
                    let values = all[*index].as_deref().unwrap_or_default();
                    narrow(values, &raw.path, &format!("{stem}{name}"))
                })
                .collect::<Result<Vec<_>, _>>()
        };
        Ok(FlightSeries {
            name: raw
                .path
                .file_name()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            inputs: pick(&raw.inputs, inputs, &self.channel_names, "")?,
            outputs: pick(&raw.outputs, outputs, &self.output_names, "r.")?,
            usable: raw.usable.clone(),
        })
    }

    /// Number of usable ticks.
    pub fn usable_ticks(&self) -> usize {
        self.flights.iter().map(|flight| flight.usable.iter().filter(|u| **u).count()).sum()
    }

    /// Sha-256 over names, `M_bar` and every number, in hex. Equal data give an equal hash, whatever container holds them.
    pub fn hash(&self) -> String {
        let mut hash = Sha256::new();
        for name in self.channel_names.iter().chain(&self.output_names) {
            hash.update(name.as_bytes());
            hash.update([0]);
        }
        for value in &self.nominal_inertia {
            hash.update(value.to_le_bytes());
        }
        for flight in &self.flights {
            hash.update((flight.ticks() as u64).to_le_bytes());
            for value in flight.inputs.iter().chain(&flight.outputs).flatten() {
                hash.update(value.to_le_bytes());
            }
            hash.update(flight.usable.iter().map(|u| u8::from(*u)).collect::<Vec<u8>>());
        }
        hash.finalize().iter().fold(String::new(), |text, byte| format!("{text}{byte:02x}"))
    }
}

/// The values as `f32`; an error if one is not finite.
fn narrow(values: &[f64], path: &Path, channel: &str) -> Result<Vec<f32>, LearnError> {
    let one = |(tick, value): (usize, &f64)| {
        let narrowed = *value as f32;
        if narrowed.is_finite() {
            return Ok(narrowed);
        }
        Err(LearnError::NotFinite {
            path: path.to_owned(),
            channel: channel.to_owned(),
            value: *value,
            tick,
        })
    };
    values.iter().enumerate().map(one).collect()
}

fn read_one(path: &Path) -> Result<Raw, LearnError> {
    match read_recording(path) {
        Ok(recording) => own(path, &recording),
        // The file is an MCAP or ULog file of another program.
        Err(error) => match OpenedFlight::open_whole(path, None) {
            Ok(opened) if !opened.is_own() => Ok(foreign::raw(&opened)),
            _ => Err(error.into()),
        },
    }
}

/// Reads a flight that this program recorded.
fn own(path: &Path, recording: &Recording) -> Result<Raw, LearnError> {
    if let Some(warning) = &recording.warning {
        return Err(LearnError::Truncated(warning.clone()));
    }
    let ticks = &recording.ticks;
    let column = |take: &dyn Fn(usize) -> f64| Some((0..ticks.len()).map(take).collect());
    let mut inputs = Vec::with_capacity(3 * N);
    inputs.extend((0..N).map(|row| column(&|t| ticks[t].measurement.chi[row])));
    inputs.extend((0..N).map(|row| column(&|t| ticks[t].measurement.chi_dot[row])));
    inputs.extend(
        (0..N).map(|row| column(&|t| ticks[t.saturating_sub(1)].measurement.tau_applied[row])),
    );
    let outputs = (0..N).map(|row| column(&|t| ticks[t].residual[row])).collect();
    let m_bar = recorded_nominal_inertia(recording)
        .ok_or_else(|| LearnError::NoInertia { path: path.to_owned() })?;
    Ok(Raw {
        path: path.to_owned(),
        inputs,
        outputs,
        usable: ticks.iter().map(usable).collect(),
        nominal_inertia: m_bar.iter().copied().collect(),
    })
}

/// Whether the residual of a tick may be learned: adaptation is not frozen, as it is in contact, and the tick has no fault.
fn usable(tick: &Tick) -> bool {
    tick.reference.adaptation == Adaptation::Free
        && !tick.reference.follows_measurement
        && tick.fault.is_none()
}
