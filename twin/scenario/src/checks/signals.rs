//! Signals of a tick that a check may limit. A signal uses the truth where it is known, otherwise the estimate.

use twin_core::elementary::{acos, cos};
use twin_core::notation::{Coords, tracking_error};
use twin_core::tick::Tick;

/// Reads a signal; `None` where the tick does not have it.
pub type ReadSignal = fn(&Tick) -> Option<f64>;

/// The signal from which a metric of the whole flight is computed, for metrics that are not named like their signal.
const OF_METRICS: &[(&str, &str)] = &[
    ("position_rmse_m", "position_error_m"),
    ("position_rmse_settled_m", "position_error_m"),
    ("position_rmse_transport_m", "position_error_m"),
    ("innovation_mean_peak", "innovation_mean"),
    ("saturation_share", "saturated"),
    ("tilt_peak_rad", "tilt_rad"),
];

const SIGNALS: &[(&str, ReadSignal)] = &[
    ("position_error_m", |tick| Some(error(tick).fixed_rows::<3>(0).norm())),
    ("error_x_m", |tick| Some(error(tick)[0])),
    ("error_y_m", |tick| Some(error(tick)[1])),
    ("error_z_m", |tick| Some(error(tick)[2])),
    ("error_yaw_rad", |tick| Some(error(tick)[5].abs())),
    ("error_joints_rad", |tick| Some(error(tick).fixed_rows::<2>(6).norm())),
    ("estimate_error_m", |tick| {
        let truth = tick.truth.as_ref()?;
        Some((*tick.measurement.chi - truth.chi).fixed_rows::<3>(0).norm())
    }),
    ("estimate_error_rad", |tick| {
        let truth = tick.truth.as_ref()?;
        let difference = tracking_error(&tick.measurement.chi, &truth.chi);
        Some(difference.fixed_rows::<3>(3).norm())
    }),
    ("height_m", |tick| Some(chi(tick)[2])),
    ("speed_m_s", |tick| {
        let measured = &*tick.measurement.chi_dot;
        let rates = tick.truth.as_ref().map_or(measured, |truth| &truth.chi_dot);
        Some(rates.fixed_rows::<3>(0).norm())
    }),
    ("tilt_rad", |tick| {
        let chi = chi(tick);
        Some(acos((cos(chi[3]) * cos(chi[4])).clamp(-1.0, 1.0)))
    }),
    ("collision_force_n", |tick| tick.truth.as_ref().map(|truth| truth.collision_force_n)),
    ("grip_force_n", |tick| tick.truth.as_ref().map(|truth| truth.grip_force_n)),
    ("payload_height_m", |tick| tick.truth.as_ref().map(|truth| truth.payload_position.z)),
    ("payload_speed_m_s", |tick| tick.truth.as_ref().map(|truth| truth.payload_speed_m_s)),
    ("wind_m_s", |tick| tick.truth.as_ref().map(|truth| truth.wind_in_world.norm())),
    ("residual_z_n", |tick| Some(tick.residual[2])),
    ("estimate_z_n", |tick| Some(tick.setpoint.r_hat[2])),
    ("innovation_mean", |tick| Some(tick.adapted.innovation_mean_norm)),
    ("weight_norm", |tick| Some(tick.adapted.weight_norm)),
    ("covariance_trace", |tick| Some(tick.adapted.covariance_trace)),
    ("rotor_command_n", |tick| tick.actuators.rotor_thrust_n.iter().copied().reduce(f64::max)),
    ("saturated", |tick| Some(f64::from(u8::from(tick.measurement.saturated)))),
    ("fault", |tick| Some(f64::from(u8::from(tick.fault.is_some())))),
];

/// Names of all signals; the unit is the end of the name.
pub fn names() -> impl Iterator<Item = &'static str> {
    SIGNALS.iter().map(|(name, _)| *name)
}

/// The signal that a demand on `name` limits, a signal or a metric, with its reader; `None` if the demand limits no number of a tick.
pub fn limited_signal(name: &str) -> Option<(&'static str, ReadSignal)> {
    let of_metric = OF_METRICS.iter().find(|(metric, _)| *metric == name);
    let wanted = of_metric.map_or(name, |(_, signal)| signal);
    SIGNALS.iter().find(|(known, _)| *known == wanted).copied()
}

/// How the signal `name` is read; `None` if there is none of that name.
pub fn find(name: &str) -> Option<ReadSignal> {
    SIGNALS.iter().find(|(known, _)| *known == name).map(|(_, read)| *read)
}

fn chi(tick: &Tick) -> &Coords {
    tick.truth.as_ref().map_or(&*tick.measurement.chi, |truth| &truth.chi)
}

/// Tracking error of the true coordinates against the reference, m and rad.
fn error(tick: &Tick) -> Coords {
    tracking_error(chi(tick), &tick.reference.chi_des)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_demand_on_a_metric_limits_the_signal_from_which_it_is_computed() {
        let of = |name| limited_signal(name).map(|(signal, _)| signal);
        assert_eq!(of("tilt_rad"), Some("tilt_rad"));
        assert_eq!(of("position_rmse_settled_m"), Some("position_error_m"));
        assert_eq!(of("flight_s"), None, "a duration is no number of a tick");
        for (metric, signal) in OF_METRICS {
            assert!(find(signal).is_some(), "{metric} names the unknown signal {signal}");
        }
    }
}
