//! The channels of what the loop foresees: the forecast at the lead, how it met the measurement, and the forecast over its horizon.

use super::{Builder, OF_RESIDUAL};
use twin_core::foreseen::Foreseen;
use twin_core::notation::{KnownCoords, known_in_both};
use twin_core::residual::foresight::corrected;
use twin_core::tick::Tick;

const GROUP: &str = "foresight";

/// Steps of the forecast that have channels, ticks. The step of now is the channel `adapted`.
const FAN_TICKS: [usize; 5] = [5, 10, 15, 20, 25];

impl Builder {
    /// Forecast at the lead, its error, band and trust, and the steps of the fan.
    pub(super) fn foresight(&mut self) {
        self.foreseen("foreseen", "forecast at the lead", |f| f.r_hat);
        self.rows(GROUP, OF_RESIDUAL, "foretold", "forecast made one lead ago", foretold);
        self.foreseen("foresight_error", "measured − forecast at the lead", |f| f.error);
        self.foreseen("foresight_std", "standard deviation at the lead", |f| f.std);
        self.foreseen("foresight_std_now", "standard deviation of now", |f| f.std_now);
        self.rows(GROUP, ["", ""], "trust", "trust in the forecast", |tick| {
            Some(tick.foreseen.as_ref()?.trust.into())
        });
        self.rows(GROUP, ["s", "s"], "lead_s", "lead", |tick| {
            Some(tick.foreseen.as_ref()?.lead_s.into())
        });
        for ticks in FAN_TICKS {
            let label = format!("forecast {ticks} ticks ahead");
            let take = move |tick: &Tick| corrected(&tick.forecast, &tick.adapted, ticks);
            self.rows(GROUP, OF_RESIDUAL, &format!("fan_{ticks:02}"), &label, take);
        }
    }

    fn foreseen(&mut self, stem: &str, label: &str, take: fn(&Foreseen) -> KnownCoords) {
        self.rows(GROUP, OF_RESIDUAL, stem, label, move |tick| tick.foreseen.as_ref().map(take));
    }
}

/// The forecast that was made for this tick one lead ago, N and N m: the measured residual without the error of that forecast.
fn foretold(tick: &Tick) -> Option<KnownCoords> {
    let error = &tick.foreseen.as_ref()?.error;
    let known = known_in_both(error.known(), tick.residual.known());
    Some(KnownCoords::from(*tick.residual - **error).only(known))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{channels, value};
    use super::*;
    use twin_core::notation::Coords;
    use twin_record::fixture;

    #[test]
    fn each_channel_of_the_foresight_comes_from_its_own_field() {
        let tick = fixture::tick(3);
        let foreseen = tick.foreseen.clone().expect("the loop looks ahead");
        let channels = channels(4);
        for (name, wanted) in [
            ("foreseen.z", foreseen.r_hat[2]),
            ("foresight_error.q1", foreseen.error[6]),
            ("foresight_std.y", foreseen.std[1]),
            ("foresight_std_now.y", foreseen.std_now[1]),
            ("foretold.x", tick.residual[0] - foreseen.error[0]),
            ("trust.psi", 0.75),
            ("lead_s.x", 0.1),
        ] {
            let found = value(&channels, &tick, name);
            assert_eq!(found.to_bits(), (wanted as f32).to_bits(), "{name}");
        }
    }

    #[test]
    fn without_a_foresight_and_before_the_first_comparison_the_channels_are_unknown() {
        let (channels, mut tick) = (channels(4), fixture::tick(3));
        if let Some(foreseen) = &mut tick.foreseen {
            foreseen.error = KnownCoords::unknown();
        }
        assert!(value(&channels, &tick, "foretold.x").is_nan());
        tick.foreseen = None;
        for name in ["foreseen.x", "foretold.x", "foresight_std.x", "trust.x", "lead_s.x"] {
            assert!(value(&channels, &tick, name).is_nan(), "{name}");
        }
    }

    #[test]
    fn the_fan_is_the_forecast_with_both_corrections_and_ends_at_the_horizon() {
        let mut tick = fixture::tick(3);
        tick.forecast.base = (0..=12).map(|j| Coords::repeat(f64::from(j)).into()).collect();
        tick.adapted.r_hat = Coords::repeat(0.25).into();
        tick.adapted.horizon = vec![Coords::repeat(0.5); 6];
        let channels = channels(4);
        assert_eq!(value(&channels, &tick, "fan_05.q1").to_bits(), 5.75_f32.to_bits());
        assert_eq!(value(&channels, &tick, "fan_10.x").to_bits(), 10.75_f32.to_bits());
        assert!(value(&channels, &tick, "fan_15.x").is_nan(), "beyond the horizon");
    }
}
