//! What a flight adds to the channels: the unit of its forces, the known weight in its residual, and the signals that its demands limit.

use std::sync::Arc;

use super::{Channels, plain};
use twin_core::tick::Tick;

/// Stems of the channels whose row z has the whole residual as value, and therefore the weight in it; an error, a bias or a standard
/// deviation has not.
const WITH_WEIGHT: [&str; 11] = [
    "residual", "base", "adapted", "r_hat", "foreseen", "foretold", "fan_05", "fan_10", "fan_15",
    "fan_20", "fan_25",
];

/// Groups whose forces belong to the residual.
const OF_RESIDUAL: [&str; 3] = ["residual", "foresight", "adapter"];

impl Channels {
    /// Adds a channel with the value `take` of a tick after the others.
    pub(crate) fn append(
        &mut self,
        group: &str,
        unit: &str,
        name: &str,
        label: &str,
        take: impl Fn(&Tick) -> Option<f64> + Send + Sync + 'static,
    ) {
        self.takes.push(Box::new(move |sample| take(sample.tick)));
        Arc::make_mut(&mut self.infos).push(plain(group, unit, name, label));
    }

    /// The channels of a vehicle whose weight is known: its residual along z is at least this large, in the unit of the channel.
    #[must_use]
    pub fn with_weight(mut self, weight: Option<f64>) -> Self {
        for info in Arc::make_mut(&mut self.infos) {
            let (stem, row) = info.name.rsplit_once('.').unwrap_or_default();
            if row == "z" && WITH_WEIGHT.contains(&stem) {
                info.weight = weight;
            }
        }
        self
    }

    /// The channels of a vehicle whose mass is unknown: its forces are per kilogram.
    #[must_use]
    pub fn per_kilogram(mut self, yes: bool) -> Self {
        let forces = Arc::make_mut(&mut self.infos)
            .iter_mut()
            .filter(|info| yes && info.unit == "N" && OF_RESIDUAL.contains(&info.group.as_str()));
        for info in forces {
            "N/kg".clone_into(&mut info.unit);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::channels;

    #[test]
    fn only_numbers_with_the_whole_residual_along_z_have_the_weight_in_them() {
        let channels = channels(4).with_weight(Some(29.0));
        let heavy: Vec<&str> = channels
            .infos()
            .iter()
            .filter(|info| info.weight == Some(29.0))
            .map(|info| info.name.as_str())
            .collect();
        assert_eq!(
            heavy,
            [
                "residual.z",
                "base.z",
                "adapted.z",
                "r_hat.z",
                "foreseen.z",
                "foretold.z",
                "fan_05.z",
                "fan_10.z",
                "fan_15.z",
                "fan_20.z",
                "fan_25.z",
            ]
        );
    }

    #[test]
    fn without_a_mass_the_forces_of_the_residual_are_per_kilogram_and_nothing_else_is() {
        let unit = |yes: bool, name: &str| {
            let channels = channels(4).per_kilogram(yes);
            channels.infos().iter().find(|info| info.name == name).map(|info| info.unit.clone())
        };
        for (name, with_mass, without) in [
            ("residual.x", "N", "N/kg"),
            ("foresight_error.z", "N", "N/kg"),
            ("bias.y", "N", "N/kg"),
            ("residual.phi", "N m", "N m"),
            ("rotor.0", "N", "N"),
            ("chi.x", "m", "m"),
        ] {
            assert_eq!(unit(false, name).as_deref(), Some(with_mass), "{name}");
            assert_eq!(unit(true, name).as_deref(), Some(without), "{name}");
        }
    }
}
