//! Encodes the ticks of a flight as the telemetry frames of the console's protocol, and packs them for a page.

use std::io::Write;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;

use super::spectra::Spectra;
use crate::server::channels::{Channels, RowSource};
use crate::server::telemetry::{Picture, Telemetry};
use twin_core::tick::Tick;
use twin_core::tuning::Tuning;
use twin_record::scene::Scene;

/// Ticks per frame. Every tick has its row of channels; a frame has the poses of its last tick, so there are 50 pictures a second.
const FRAME_TICKS: usize = 2;

/// The encoded frames of a flight.
pub(super) fn frames(
    scene: &Scene,
    channels: &Channels,
    tuning: &Tuning,
    ticks: &[Tick],
) -> Vec<Vec<u8>> {
    let mut spectra = Spectra::new(&tuning.adapter);
    let unbroken = ticks.chunk_by(|a, b| b.index == a.index + 1);
    let parts = unbroken.flat_map(|part| part.chunks(FRAME_TICKS));
    parts
        .filter_map(|part| {
            let (first, last) = (part.first()?, part.last()?);
            let mut spectrum: &[f64] = &[];
            let mut rows = Vec::with_capacity(part.len());
            for tick in part {
                spectrum = spectra.at(tick);
                rows.push(channels.row(&RowSource { tick, tuning, spectrum }));
            }
            let frame = Telemetry {
                schema_id: super::SCHEMA_ID,
                first_tick: first.index,
                rows,
                gap: 0,
                reset: false,
                picture: Arc::new(Picture::new(scene, last, spectrum)),
            };
            Some(frame.encode(0.0))
        })
        .collect()
}

/// Writes `head` and each of the `frames` after its length (u32, little-endian), compresses all with gzip and encodes it as base64.
pub(super) fn packed(head: &[u8], frames: &[Vec<u8>]) -> std::io::Result<String> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    for part in std::iter::once(head).chain(frames.iter().map(Vec::as_slice)) {
        encoder.write_all(&(part.len() as u32).to_le_bytes())?;
        encoder.write_all(part)?;
    }
    Ok(STANDARD.encode(encoder.finish()?))
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;
    use twin_core::residual::PredictorInfo;
    use twin_record::fixture;
    use twin_scenario::ActuatorLimits;

    #[test]
    fn every_tick_has_a_row_and_frames_do_not_reach_over_a_lost_tick() {
        let limits =
            ActuatorLimits { rotor_thrust_n: [0.0, 10.0], joint_torque_n_m: [None, Some(1.0)] };
        let scene = fixture::scene();
        let channels = Channels::new(scene.rotors.len(), &limits, &PredictorInfo::default());
        let mut ticks: Vec<Tick> = (0..9).map(fixture::tick).collect();
        ticks.remove(4);
        let tuning = Tuning {
            gains: twin_core::control::Gains::preset(twin_core::control::Preset::Tuned),
            adapter: twin_core::residual::lra::Settings::default(),
        };
        let frames = frames(&scene, &channels, &tuning, &ticks);
        // From the protocol: first tick at byte 4, rows at byte 8.
        let spans: Vec<(u8, u8)> = frames.iter().map(|frame| (frame[4], frame[8])).collect();
        assert_eq!(spans, [(0, 2), (2, 2), (5, 2), (7, 2)]);
    }

    #[test]
    fn what_is_packed_can_be_taken_apart_again() {
        let packed = packed(b"{}", &[vec![1, 2, 3], vec![]]).unwrap();
        let mut bytes = Vec::new();
        let gzip = STANDARD.decode(packed).unwrap();
        flate2::read::GzDecoder::new(gzip.as_slice()).read_to_end(&mut bytes).unwrap();
        assert_eq!(bytes, [2, 0, 0, 0, b'{', b'}', 3, 0, 0, 0, 1, 2, 3, 0, 0, 0, 0]);
    }
}
