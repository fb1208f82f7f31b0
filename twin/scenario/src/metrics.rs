//! Metrics by which a flight is judged. Names are `snake_case` with the unit last.
//!
//! `e8` is the norm of the tracking error in m and rad: true position, yaw and joints against the reference, roll and pitch against the
//! command filter. `rms_error_e8` covers every tick from 2 s on; `rms_error_e8_transport` covers the ticks with the payload in the gripper,
//! from lift-off to touchdown. `position_rmse_settled_m` covers every tick from 8 s on: a path alone begins with the payload in the
//! gripper, and its weight kicks the vehicle, whose estimate starts empty.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::course::FROM_S;
use super::coverage::Coverage;
use super::rms::Rms;
use twin_core::elementary::{acos, cos, squared};
use twin_core::notation::{COORDINATE_NAMES, Coords, N, tracking_error};
use twin_core::residual::NOMINAL_SCALE;
use twin_core::tick::{EventKind, Tick};

/// Time from which a path alone is settled, s.
const SETTLED_S: f64 = 8.0;

/// Accumulates the metrics of one flight.
#[derive(Clone, Debug, Default)]
pub struct Metrics {
    e8: Rms,
    e8_transport: Rms,
    position: Rms,
    position_transport: Rms,
    position_settled: Rms,
    coverage: Coverage,
    rows: [Rms; N],
    prediction: [Rms; N],
    persistence: [Rms; N],
    residual_sum: Coords,
    residual_squares: Coords,
    residual_count: f64,
    previous_residual: Option<Coords>,
    speed_sum: f64,
    speed_count: f64,
    saturated: f64,
    ticks: f64,
    resets: f64,
    retries: f64,
    grasp_s: Option<f64>,
    palm: Option<Vector3<f64>>,
    slip_m: f64,
    innovation: Vec<f64>,
    innovation_peak: f64,
    tilt_peak_rad: f64,
    last: Option<Last>,
}

/// State of the payload at the last tick.
#[derive(Clone, Copy, Debug)]
struct Last {
    payload: Vector3<f64>,
    tilt_rad: f64,
    t_s: f64,
}

impl Metrics {
    /// Adds a tick.
    pub fn add(&mut self, tick: &Tick) {
        let t_s = tick.measurement.t_s;
        self.ticks += 1.0;
        self.saturated += f64::from(u8::from(tick.measurement.saturated));
        self.resets += f64::from(u8::from(tick.adapted.reset));
        for event in &tick.events {
            match event.kind {
                EventKind::Retry => self.retries += 1.0,
                EventKind::Grasp => self.grasp_s = Some(self.grasp_s.unwrap_or(t_s)),
                _ => {}
            }
        }
        if t_s >= FROM_S {
            self.add_tracking(tick);
            self.coverage.add(tick);
            self.add_prediction(tick);
            self.innovation.push(tick.adapted.innovation_mean_norm);
            self.innovation_peak = self.innovation_peak.max(tick.adapted.innovation_mean_norm);
        }
        self.previous_residual = Some(*tick.residual);
        self.add_payload(tick);
    }

    fn add_tracking(&mut self, tick: &Tick) {
        let chi = tick.truth.as_ref().map_or(&*tick.measurement.chi, |truth| &truth.chi);
        let mut e = tracking_error(chi, &tick.reference.chi_des);
        (e[3], e[4]) = (tick.control.error[3], tick.control.error[4]);
        let position_squared = e.fixed_rows::<3>(0).norm_squared();
        self.e8.add(e.norm_squared());
        self.position.add(position_squared);
        if tick.measurement.t_s >= SETTLED_S {
            self.position_settled.add(position_squared);
        }
        for (rms, value) in self.rows.iter_mut().zip(&e) {
            rms.add(value * value);
        }
        if tick.reference.transporting && !tick.reference.follows_measurement {
            self.e8_transport.add(e.norm_squared());
            self.position_transport.add(position_squared);
        }
        if tick.reference.cruising {
            let measured = &*tick.measurement.chi_dot;
            let speed = tick.truth.as_ref().map_or(measured, |truth| &truth.chi_dot);
            self.speed_sum += speed.fixed_rows::<3>(0).norm();
            self.speed_count += 1.0;
        }
    }

    /// Adds the a-priori prediction of the residual and the persistence forecast; ticks with a frozen adapter are left out.
    fn add_prediction(&mut self, tick: &Tick) {
        let Some(previous) = self.previous_residual.filter(|_| !tick.adapted.frozen) else {
            return;
        };
        self.residual_count += 1.0;
        self.residual_sum += *tick.residual;
        self.residual_squares += tick.residual.component_mul(&tick.residual);
        for row in 0..N {
            let r = tick.residual[row];
            self.prediction[row].add(squared(r - tick.adapted.r_hat_prior[row]));
            self.persistence[row].add(squared(r - previous[row]));
        }
    }

    fn add_payload(&mut self, tick: &Tick) {
        let Some(truth) = &tick.truth else { return };
        let tilt = acos((cos(truth.chi[3]) * cos(truth.chi[4])).clamp(-1.0, 1.0));
        self.tilt_peak_rad = self.tilt_peak_rad.max(tilt);
        if tick.phase == "close" || tick.phase == "approach" {
            self.palm = None;
            self.slip_m = 0.0;
        } else if tick.reference.transporting {
            let held = *self.palm.get_or_insert(truth.payload_in_palm);
            self.slip_m = self.slip_m.max((truth.payload_in_palm - held).norm());
        }
        self.last = Some(Last {
            payload: truth.payload_position,
            tilt_rad: truth.payload_tilt_rad,
            t_s: tick.measurement.t_s,
        });
    }

    /// The metrics by name. `place` is the target position of the payload, m, if there is one. Metrics without data are left out.
    pub fn finish(mut self, place: Option<Vector3<f64>>) -> BTreeMap<String, f64> {
        let mut out = BTreeMap::new();
        let mut put = |name: &str, value: Option<f64>| {
            if let Some(value) = value.filter(|v| v.is_finite()) {
                out.insert(name.to_owned(), value);
            }
        };
        put("rms_error_e8", self.e8.value());
        put("rms_error_e8_transport", self.e8_transport.value());
        put("position_rmse_m", self.position.value());
        put("position_rmse_settled_m", self.position_settled.value());
        put("position_rmse_transport_m", self.position_transport.value());
        for (row, rms) in COORDINATE_NAMES.iter().zip(&self.rows) {
            let unit = if matches!(*row, "x" | "y" | "z") { "m" } else { "rad" };
            put(&format!("rms_error_{row}_{unit}"), rms.value());
        }
        put(
            "transport_speed_m_s",
            (self.speed_count > 0.0).then(|| self.speed_sum / self.speed_count),
        );
        put("residual_rmse_z", pooled_rmse_z(&self.prediction));
        put("persistence_rmse_z", pooled_rmse_z(&self.persistence));
        put("residual_r2", self.r_squared());
        put("band_coverage", self.coverage.flight());
        put("band_coverage_pickup", self.coverage.pickup());
        put("saturation_share", Some(self.saturated / self.ticks.max(1.0)));
        put("resets", Some(self.resets));
        put("retries", Some(self.retries));
        put("time_to_grasp_s", self.grasp_s);
        put("innovation_mean_peak", Some(self.innovation_peak));
        put("innovation_mean_q999", quantile(&mut self.innovation, 0.999));
        put("tilt_peak_rad", Some(self.tilt_peak_rad));
        put("grasp_slip_mm", self.palm.and(place).map(|_| self.slip_m * 1e3));
        if let Some(last) = self.last {
            put("flight_s", Some(last.t_s));
            put("placement_error_mm", place.map(|place| (last.payload - place).xy().norm() * 1e3));
            put("placement_tilt_rad", place.map(|_| last.tilt_rad));
        }
        out
    }

    /// R² of the a-priori estimate: mean over coordinates of `1 - sum (r - r_hat)^2 / sum (r - mean r)^2`.
    fn r_squared(&self) -> Option<f64> {
        let n = self.residual_count;
        (n > 1.0).then(|| {
            let per_row = (0..N).map(|row| {
                let spread = self.residual_squares[row] - squared(self.residual_sum[row]) / n;
                1.0 - self.prediction[row].sum / spread.max(f64::MIN_POSITIVE)
            });
            per_row.sum::<f64>() / N as f64
        })
    }
}

/// Root mean square over coordinates and time; each coordinate is divided by the residual's standard deviation.
fn pooled_rmse_z(rows: &[Rms; N]) -> Option<f64> {
    let sum: f64 =
        rows.iter().zip(NOMINAL_SCALE).map(|(row, scale)| row.sum / (scale * scale)).sum();
    let count: f64 = rows.iter().map(|row| row.count).sum();
    (count > 0.0).then(|| (sum / count).sqrt())
}

fn quantile(values: &mut [f64], q: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let index = ((values.len() as f64 - 1.0) * q).round();
    values.get(index.max(0.0) as usize).copied()
}
