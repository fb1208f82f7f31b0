//! The twin that flies beside a recording, for `twin mirror --headless`.

use std::io::{self, Write};
use std::path::Path;

use anyhow::Context;
use twin_core::notation::{COORDINATE_NAMES, TICK_S};
use twin_foreign::OpenedFlight;
use twin_foreign::divergence::HORIZONS;
use twin_foreign::{DivergenceReport, Flyer, Light, Shadow, Twin, TwinFlight};

/// The twin of the vehicle in `urdf`, or one rigid body of the known mass and inertia.
pub(super) fn twin(urdf: Option<&Path>, opened: &OpenedFlight) -> anyhow::Result<Twin> {
    Ok(match urdf {
        Some(file) => Twin::urdf(file, &opened.recorded.joint_names)?,
        None => Twin::of(opened),
    })
}

/// Divergence of the twin from the flight.
pub(super) struct Divergence {
    report: DivergenceReport,
    from: Option<TwinFlight>,
}

impl Divergence {
    /// Flies the twin along the whole flight, and also once from `fly_from`, s, if it is given.
    pub(super) fn new(
        opened: &OpenedFlight,
        shadow: &Shadow,
        twin: Twin,
        fly_from: Option<f64>,
    ) -> anyhow::Result<Self> {
        let flyer = Flyer::new(shadow.playback(), opened, twin);
        let from = match fly_from {
            None => None,
            Some(t_s) => {
                let tick = (t_s / TICK_S).round().max(0.0) as usize;
                let unknown = "the twin cannot start there: force and motion must be known from 0.5 s before to 1.1 s after this time";
                Some(flyer.from(tick).with_context(|| format!("--fly-from {t_s}: {unknown}"))?)
            }
        };
        Ok(Self { report: flyer.along(), from })
    }

    pub(super) fn json(&self) -> serde_json::Value {
        let mut found = serde_json::to_value(&self.report).unwrap_or_default();
        if let Some(shot) = &self.from {
            let after = HORIZONS.iter().zip(&shot.after).map(|(ticks, misses)| {
                let axes = COORDINATE_NAMES
                    .iter()
                    .zip(misses)
                    .map(|(row, miss)| serde_json::json!({ "row": row, "miss": miss }));
                serde_json::json!({
                    "horizon_s": *ticks as f64 * TICK_S,
                    "axes": axes.collect::<Vec<_>>(),
                    "light": Light::worst(misses),
                })
            });
            found["from"] = serde_json::json!({
                "t_s": shot.t_s,
                "own_attitude": shot.free,
                "after": after.collect::<Vec<_>>(),
            });
        }
        found
    }

    pub(super) fn print(&self, out: &mut dyn Write) -> io::Result<()> {
        let DivergenceReport { twin, commands, flights, horizons, .. } = &self.report;
        writeln!(out, "  twin beside it: {twin}; {commands}; {flights} flights of 1 s")?;
        for horizon in horizons {
            for axis in &horizon.axes {
                writeln!(
                    out,
                    "  after {:.1} s {:6} {:.3} {} ({:?}); with the residual {:.3} ({:?}); coasting {:.3}",
                    horizon.horizon_s,
                    axis.row,
                    axis.twin_rms,
                    axis.unit,
                    axis.light,
                    axis.with_residual_rms,
                    axis.light_with_residual,
                    axis.coasting_rms,
                )?;
            }
        }
        let Some(shot) = &self.from else { return Ok(()) };
        writeln!(out, "  from {:.2} s, miss of twin, with the residual, coasting:", shot.t_s)?;
        for (ticks, misses) in HORIZONS.iter().zip(&shot.after) {
            for (row, miss) in COORDINATE_NAMES.iter().zip(misses) {
                let (Some(twin), Some(with), Some(coasting)) =
                    (miss.twin, miss.with_residual, miss.coasting)
                else {
                    continue;
                };
                let after_s = *ticks as f64 * TICK_S;
                writeln!(
                    out,
                    "  after {after_s:.1} s {row:6} {twin:+.3} {with:+.3} {coasting:+.3}"
                )?;
            }
        }
        Ok(())
    }
}
