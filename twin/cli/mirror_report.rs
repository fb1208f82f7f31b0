//! What `twin mirror` found in a flight: as JSON, and for people.

use std::io::{self, Write};

use twin_foreign::{Effort, OpenedFlight, ShadowReport};

/// What was found, as one JSON object.
pub(super) fn json(opened: &OpenedFlight, report: &ShadowReport) -> serde_json::Value {
    let OpenedFlight { path, survey, map, map_name, signals, recorded, .. } = opened;
    let empty: Vec<&str> = survey
        .channels
        .iter()
        .filter(|info| info.messages == 0)
        .map(|info| info.topic.as_str())
        .collect();
    serde_json::json!({
        "file": path.display().to_string(),
        "map": map_name,
        "vehicle": map.vehicle,
        "mass_in_use_kg": recorded.mass_kg,
        "forces_are_per_kilogram": opened.per_kilogram(),
        "container": survey.container,
        "ambiguous_schemas": survey.ambiguous_schemas,
        "empty_channels": empty,
        "used": signals.used,
        "vehicles": opened.vehicles,
        "joints": signals.joints.as_ref().map(|(names, _)| names),
        "notes": signals.notes,
        "effort": recorded.effort,
        "fit": fit(opened),
        "phases": recorded.spans,
        "acceleration": { "translation": recorded.acceleration[0], "rotation": recorded.acceleration[1] },
        "shadow": report,
    })
}

/// Whether the thrust explains the motion; `null` without a fit.
fn fit(opened: &OpenedFlight) -> serde_json::Value {
    match &opened.recorded.effort {
        Effort::Wrench { fit: Some(fit) } | Effort::Fitted { fit, .. } => serde_json::json!({
            "r2": fit.r2,
            "explains": fit.explains(),
            "verdict": fit.verdict(),
        }),
        _ => serde_json::Value::Null,
    }
}

pub(super) fn print_report(
    out: &mut dyn Write,
    opened: &OpenedFlight,
    report: &ShadowReport,
) -> io::Result<()> {
    let OpenedFlight { path, map_name, signals, recorded, .. } = opened;
    writeln!(out, "{} (map {map_name})", path.display())?;
    for used in &signals.used {
        writeln!(
            out,
            "  {:<17} {} {:.1} Hz, {} gaps, longest {:.3} s, clock {:?}, latency {:+.1} ms; left out: {} twice, {} back in time, {} not finite, {} repeated, {} merged",
            format!("{:?}", used.quantity),
            used.topic,
            used.timing.rate_hz,
            used.timing.gaps,
            used.timing.longest_gap_s,
            used.time.clock,
            used.time.latency_ms,
            used.timing.duplicate,
            used.timing.backwards,
            used.timing.not_finite,
            used.timing.repeated,
            used.timing.merged,
        )?;
    }
    for note in &signals.notes {
        writeln!(out, "  note: {note}")?;
    }
    if opened.per_kilogram() {
        writeln!(out, "  the mass is unknown: forces are per kilogram")?;
    }
    writeln!(
        out,
        "  acceleration of translation from {:?}, of rotation from {:?}",
        recorded.acceleration[0], recorded.acceleration[1]
    )?;
    writeln!(out, "  {}", opened.force_sentence())?;
    writeln!(out, "  {}", opened.torque_sentence())?;
    for span in &recorded.spans {
        let (from_s, to_s, phase) = (span.from_s, span.to_s, span.phase.words());
        writeln!(out, "  {from_s:7.2} to {to_s:7.2} s {phase}: {}", span.why)?;
    }
    print_shadow(out, report)
}

fn print_shadow(out: &mut dyn Write, report: &ShadowReport) -> io::Result<()> {
    writeln!(
        out,
        "  {} ticks, {:.1} s, {} in the air, {} without a residual there",
        report.ticks, report.flight_s, report.airborne_ticks, report.held_ticks
    )?;
    for row in &report.scored.rows {
        match &row.residual {
            None => writeln!(out, "  r {:6} unknown", row.row)?,
            Some(r) => writeln!(
                out,
                "  r {:6} {:9.4} +- {:.4} {} ({:.4} .. {:.4}), known {:.0} %",
                row.row,
                r.mean,
                r.std,
                r.unit,
                r.min,
                r.max,
                100.0 * row.residual_known
            )?,
        }
    }
    writeln!(out, "  predictor: {}; resets at {:?} s", report.predictor, report.resets_s)?;
    for horizon in &report.scored.prediction {
        let text = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.4}"));
        let share = horizon.band_90_holds.map_or_else(String::new, |share| {
            let half_width = text(horizon.band_90_z);
            format!("; band of 90 % +- {half_width} z holds {:.1} %", 100.0 * share)
        });
        writeln!(
            out,
            "  j = {}: RMSE {} z, persistence {} z, mean {} z{share}",
            horizon.j,
            text(horizon.rmse_z),
            text(horizon.persistence_rmse_z),
            text(horizon.mean_rmse_z),
        )?;
    }
    writeln!(out, "  gate: {}", report.gate)?;
    Ok(())
}
