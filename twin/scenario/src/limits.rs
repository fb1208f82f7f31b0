//! What numbers a scenario may hold, and which slip of the unit a number out of range looks like.

use twin_core::notation::ROWS;
use twin_core::tuning::Tuning;

/// The range of every number whose key matches.
pub(super) struct Limit {
    /// Dotted key without list indices; one `*` in a segment stands for any characters of it.
    key: &'static str,
    min: f64,
    max: f64,
    unit: &'static str,
}

const fn limit(key: &'static str, min: f64, max: f64, unit: &'static str) -> Limit {
    Limit { key, min, max, unit }
}

/// Largest whole number a double holds exactly; a seed beyond it would change in JSON.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// The first entry that matches counts.
const LIMITS: &[Limit] = &[
    limit("seed", 0.0, MAX_EXACT, ""),
    limit("time_limit_s", 1.0, 3600.0, "s"),
    limit("vehicle.rotors.position_m", -5.0, 5.0, "m"),
    limit("vehicle.rotors.spin", -1.0, 1.0, ""),
    limit("vehicle.rotor.max_thrust_n", 0.1, 500.0, "N"),
    limit("vehicle.rotor.min_thrust_n", 0.0, 100.0, "N"),
    limit("vehicle.rotor.torque_ratio_m", 0.0, 1.0, "m"),
    limit("vehicle.rotor.*lag_s", 0.0, 0.5, "s"),
    limit("vehicle.rotor.delay_s", 0.0, 0.1, "s"),
    limit("vehicle.rotor.thrust_scale", 0.5, 1.5, ""),
    limit("vehicle.rotor.thrust_coefficient_n_s2", 1e-9, 1.0, "N s²"),
    limit("vehicle.rotor.radius_m", 0.01, 1.0, "m"),
    limit("vehicle.joint_armature_kg_m2", 0.0, 1.0, "kg m²"),
    limit("vehicle.joint_delay_s", 0.0, 0.1, "s"),
    limit("vehicle.gripper.*_m_s", 0.0, 1.0, "m/s"),
    limit("vehicle.gripper.force_n", 0.0, 100.0, "N"),
    limit("vehicle.gripper.friction", 0.0, 2.0, ""),
    limit("arena.friction", 0.0, 2.0, ""),
    limit("arena.objects.position_m", -100.0, 100.0, "m"),
    limit("payload.mass_kg", 0.0, 1.0, "kg"),
    limit("payload.size_m", 0.01, 0.12, "m"),
    limit("payload.friction", 0.0, 2.0, ""),
    limit("payload.position_m", -100.0, 100.0, "m"),
    limit("payload.position_spread_m", 0.0, 1.0, "m"),
    limit("payload.yaw_std_rad", 0.0, 3.2, "rad"),
    limit("task.speed_m_s", 0.05, 2.0, "m/s"),
    limit("task.*_m_s", 0.0, 5.0, "m/s"),
    limit("task.*_m", -100.0, 100.0, "m"),
    limit("task.*_s", 0.0, 3600.0, "s"),
    limit("task.excitation.*_m_s", 0.05, 3.0, "m/s"),
    limit("task.excitation.*_m_s2", 0.05, 10.0, "m/s²"),
    limit("task.excitation.*_m", -5.0, 5.0, "m"),
    limit("task.excitation.*_rad", -3.2, 3.2, "rad"),
    limit("controller.l1.pole_per_s", 0.1, 90.0, "1/s"),
    limit("controller.l1.cutoff_rad_s", 0.05, 200.0, "rad/s"),
    limit("controller.multisine.tones", 0.0, 100.0, ""),
    limit("controller.multisine.*_hz", 0.01, 50.0, "Hz"),
    limit("controller.multisine.rms", 0.0, 20.0, ""),
    limit("aero.rotor_drag_n_s_m", 0.0, 10.0, "N s/m"),
    limit("aero.body_drag_n_s2_m2", 0.0, 10.0, "N s²/m²"),
    limit("aero.ground_effect_radius_m", 0.0, 5.0, "m"),
    limit("aero.link_drag_area_m2", 0.0, 1.0, "m²"),
    limit("aero.turbulence_n", 0.0, 50.0, "N"),
    limit("aero.turbulence_n_m", 0.0, 10.0, "N m"),
    limit("aero.*_s", 0.001, 60.0, "s"),
    limit("wind.*_m_s", -30.0, 30.0, "m/s"),
    limit("wind.*_s", 0.0, 3600.0, "s"),
    limit("wind.scale_m", 0.1, 1000.0, "m"),
    limit("sensors.*_hz", 0.1, 1000.0, "Hz"),
    limit("sensors.mocap_latency_s", 0.0, 0.5, "s"),
    limit("sensors.*_m_s2", 0.0, 50.0, "m/s²"),
    limit("sensors.*_rad_s", 0.0, 5.0, "rad/s"),
    limit("sensors.*_rad", 0.0, 0.5, "rad"),
    limit("sensors.*_m", 0.0, 1.0, "m"),
    limit("sensors.encoder_counts", 1.0, 1e9, ""),
    limit("contact.iterations", 1.0, 64.0, ""),
    limit("contact.*frequency_hz", 1.0, 10_000.0, "Hz"),
    limit("faults.at_s", 0.0, 3600.0, "s"),
    limit("faults.duration_s", 0.001, 3600.0, "s"),
    limit("faults.offset_m", -100.0, 100.0, "m"),
    limit("faults.accelerometer_m_s2", -50.0, 50.0, "m/s²"),
    limit("faults.gyro_rad_s", -5.0, 5.0, "rad/s"),
    limit("faults.rotor", 0.0, 64.0, ""),
    limit("faults.factor", 0.0, 1.5, ""),
    limit("faults.friction", 0.0, 2.0, ""),
    limit("faults.velocity_m_s", -30.0, 30.0, "m/s"),
    limit("checks.quantile", 0.0, 1.0, ""),
    limit("checks.*_s", 0.0, 3600.0, "s"),
    limit("golden.every_s", 0.01, 60.0, "s"),
    limit("golden.tolerance.*", 1e-6, 1e9, ""),
    limit("sweep.seed", 0.0, MAX_EXACT, ""),
    limit("sweep.min_success", 0.0, 1.0, ""),
    limit("expect.events.*_s", 0.0, 3600.0, "s"),
];

/// A unit, a slip and the factor that turns the slip into the unit.
const SLIPS: &[(&str, &str, f64)] = &[
    ("kg", "grams", 1e-3),
    ("m", "centimetres", 1e-2),
    ("m", "millimetres", 1e-3),
    ("s", "milliseconds", 1e-3),
    ("m/s", "kilometres per hour", 1.0 / 3.6),
    ("m/s", "millimetres per second", 1e-3),
    ("m/s²", "milli-g", 9.806_65e-3),
    ("N", "grams of thrust", 9.806_65e-3),
    ("rad", "degrees", std::f64::consts::PI / 180.0),
    ("rad/s", "degrees per second", std::f64::consts::PI / 180.0),
];

/// The range of a number, in words, and the slip it looks like; nothing if `value` is allowed at `path`.
pub(super) fn violation(path: &[String], value: f64) -> Option<(String, String)> {
    let (min, max, unit) = range(path)?;
    if (min..=max).contains(&value) {
        return None;
    }
    let space = if unit.is_empty() { "" } else { " " };
    let slip = SLIPS.iter().filter(|(of, ..)| *of == unit).find_map(|(_, slip, factor)| {
        let corrected = value * factor;
        (corrected != 0.0 && (min..=max).contains(&corrected)).then_some((slip, corrected))
    });
    let hint = slip.map_or_else(String::new, |(slip, corrected)| {
        format!("; {value} looks like {slip}, write {}", rounded(corrected))
    });
    Some((format!("{min:?}..={max:?}{space}{unit}"), hint))
}

/// Six significant digits: the corrected value is a suggestion.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// Smallest and largest value of the number at `path`, and its unit.
pub(super) fn range(path: &[String]) -> Option<(f64, f64, &'static str)> {
    if path.first().is_some_and(|first| first == "gains") {
        return gain_range(&path[1..]);
    }
    let is_key = |segment: &&String| segment.parse::<usize>().is_err();
    let keys: Vec<&String> = path.iter().filter(is_key).collect();
    let matches = |limit: &&Limit| {
        let mut patterns = limit.key.split('.');
        let all = keys.iter().all(|key| patterns.next().is_some_and(|pattern| fits(pattern, key)));
        all && patterns.next().is_none()
    };
    LIMITS.iter().find(matches).map(|limit| (limit.min, limit.max, limit.unit))
}

/// Gains have one registry, which also bounds what an operator may set in flight.
fn gain_range(path: &[String]) -> Option<(f64, f64, &'static str)> {
    let name = match path {
        [name] => name.clone(),
        [name, index] => format!("{name}.{}", ROWS.get(index.parse::<usize>().ok()?)?),
        _ => return None,
    };
    let known = Tuning::parameters().into_iter().find(|parameter| parameter.name == name)?;
    Some((known.min, known.max, known.unit))
}

fn fits(pattern: &str, key: &str) -> bool {
    match pattern.split_once('*') {
        Some((head, tail)) => {
            key.len() >= head.len() + tail.len() && key.starts_with(head) && key.ends_with(tail)
        }
        None => pattern == key,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(dotted: &str) -> Vec<String> {
        dotted.split('.').map(str::to_owned).collect()
    }

    #[test]
    fn slips_of_the_unit_are_recognised() {
        for (key, value, slip) in [
            ("payload.mass_kg", 300.0, "300 looks like grams, write 0.3"),
            ("payload.size_m", 5.0, "5 looks like centimetres, write 0.05"),
            ("payload.size_m", 50.0, "50 looks like millimetres, write 0.05"),
            ("task.speed_m_s", 3.6, "3.6 looks like kilometres per hour, write 1"),
            ("sensors.mocap_noise_rad", 1.0, "1 looks like degrees, write 0.0174533"),
            ("vehicle.rotors.2.position_m.0", 230.0, "230 looks like centimetres, write 2.3"),
        ] {
            let (_, hint) = violation(&path(key), value).unwrap();
            assert_eq!(hint, format!("; {slip}"), "{key}");
        }
        assert_eq!(violation(&path("payload.mass_kg"), -0.3).unwrap().1, "");
    }

    #[test]
    fn bounds_are_allowed_and_what_lies_beyond_is_not() {
        for limit in LIMITS.iter().filter(|limit| !limit.key.contains('*')) {
            let key = path(limit.key);
            assert_eq!(violation(&key, limit.min), None, "{}", limit.key);
            assert_eq!(violation(&key, limit.max), None, "{}", limit.key);
            assert!(violation(&key, limit.min - 1.0).is_some(), "{}", limit.key);
            assert!(violation(&key, limit.max * 2.0 + 1.0).is_some(), "{}", limit.key);
            assert!(violation(&key, f64::NAN).is_some(), "{}", limit.key);
        }
    }

    #[test]
    fn a_star_stands_for_part_of_one_segment() {
        assert!(fits("*_noise_m", "position_noise_m") && !fits("*_noise_m", "position_noise_m_s"));
        assert!(fits("*", "anything") && !fits("a*a", "a"));
        assert_eq!(violation(&path("sensors.other"), 1e9), None);
        assert_eq!(
            violation(&path("arena.objects.0.position_m.1"), 1e3).unwrap().0,
            "-100.0..=100.0 m"
        );
    }
}
