//! The channels that show how a flight broke a demand: the signal that the demand limits, and its limits.

use crate::server::channels::Channels;
use twin_core::tick::Tick;
use twin_scenario::{Settings, Violation, limited_signal};

/// Name of the group of these channels.
const GROUP: &str = "demands";

/// Adds the channels for `broken`, and returns their names, the signal first; none if the demand limits no number of a tick.
pub(super) fn channels_of(
    broken: &Violation,
    settings: &Settings,
    channels: &mut Channels,
) -> Vec<String> {
    let Some((name, read)) = limited_signal(&broken.name) else { return Vec::new() };
    let unit = unit_of(name);
    let own = format!("signal.{name}");
    channels.append(GROUP, unit, &own, name, read);
    let limits = limits_of(broken, settings).into_iter().zip(["min", "max"]);
    let limits = limits.filter_map(|(limit, end)| Some((limit?, end)));
    let limits = limits.map(|(limit, end)| {
        let own = format!("limit.{}.{end}", broken.name);
        channels.append(GROUP, unit, &own, &format!("allowed {end}"), move |_: &Tick| Some(limit));
        own
    });
    std::iter::once(own).chain(limits).collect()
}

/// Smallest and largest allowed value.
fn limits_of(broken: &Violation, settings: &Settings) -> [Option<f64>; 2] {
    let bound = settings.bounds.get(&broken.name).map(|bound| [bound.min, bound.max]);
    let check = || {
        let limits = |check: &twin_scenario::Check| [check.min, check.max];
        settings.checks.iter().find(|check| check.signal == broken.name).map(limits)
    };
    bound.or_else(check).unwrap_or_default()
}

/// The unit at the end of a signal's name.
fn unit_of(name: &str) -> &'static str {
    const UNITS: [(&str, &str); 4] = [("_m_s", "m/s"), ("_rad", "rad"), ("_m", "m"), ("_n", "N")];
    UNITS.iter().find(|(end, _)| name.ends_with(end)).map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::residual::PredictorInfo;
    use twin_core::tuning::Tuning;
    use twin_record::fixture;
    use twin_scenario::ActuatorLimits;

    fn broken(name: &str) -> Violation {
        Violation {
            name: name.to_owned(),
            what: name.to_owned(),
            value: None,
            found: "1".to_owned(),
            allowed: "at most 0.3".to_owned(),
            at_s: 1.0,
        }
    }

    #[test]
    fn a_demand_shows_its_signal_and_its_limits_and_one_without_a_signal_shows_nothing() {
        let settings: Settings = twin_scenario::file::read_text(
            "[bounds.tilt_peak_rad]\nmax = 0.3\n",
            std::path::Path::new("test.toml"),
            twin_scenario::DEFAULTS,
            &[],
        )
        .expect("a scenario");
        let limits =
            ActuatorLimits { rotor_thrust_n: [0.0, 10.0], joint_torque_n_m: [None, Some(1.0)] };
        let mut channels = Channels::new(4, &limits, &PredictorInfo::default());
        let before = channels.infos().len();
        let names = channels_of(&broken("tilt_peak_rad"), &settings, &mut channels);
        assert_eq!(names, ["signal.tilt_rad", "limit.tilt_peak_rad.max"]);
        assert_eq!(channels_of(&broken("verdict"), &settings, &mut channels), [""; 0]);
        let added = &channels.infos()[before..];
        assert_eq!(added.iter().map(|info| info.unit.as_str()).collect::<Vec<_>>(), ["rad"; 2]);
        let tuning = Tuning {
            gains: twin_core::control::Gains::preset(twin_core::control::Preset::Tuned),
            adapter: twin_core::residual::lra::Settings::default(),
        };
        let tick = fixture::tick(3);
        let row = channels.row(&crate::server::channels::RowSource {
            tick: &tick,
            tuning: &tuning,
            spectrum: &[],
        });
        assert_eq!(row.last().map(|value| value.to_bits()), Some(0.3_f32.to_bits()));
    }
}
