//! Coverage of the predictive bands: the share of the residuals that lie in the band that was told one lead before.
//!
//! In: ticks. Out: shares over all coordinates, and over the second after the payload was gripped. State: the bands that wait.

use std::collections::VecDeque;

use twin_core::foreseen::Foreseen;
use twin_core::notation::{KnownCoords, N, TICK_S};
use twin_core::residual::foresight::{BAND_90, MOST_WAITING};
use twin_core::tick::{EventKind, Tick};

/// Time after the grasp in which the load is new, s.
const PICKUP_S: f64 = 1.0;

/// Errors inside the band, and all errors.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    inside: f64,
    all: f64,
}

impl Share {
    fn add(&mut self, inside: bool) {
        self.inside += f64::from(u8::from(inside));
        self.all += 1.0;
    }

    fn value(self) -> Option<f64> {
        (self.all > 0.0).then(|| self.inside / self.all)
    }
}

/// Accumulates the coverage of one flight.
#[derive(Clone, Debug, Default)]
pub(super) struct Coverage {
    /// Deviations at the lead, newest first.
    told: VecDeque<KnownCoords>,
    grasp_s: Option<f64>,
    flight: Share,
    pickup: Share,
}

impl Coverage {
    /// Adds a tick.
    pub(super) fn add(&mut self, tick: &Tick) {
        let t_s = tick.measurement.t_s;
        if tick.events.iter().any(|event| event.kind == EventKind::Grasp) {
            self.grasp_s = Some(t_s);
        }
        let Some(foreseen) = &tick.foreseen else { return };
        let new = self.grasp_s.is_some_and(|grasp_s| t_s - grasp_s < PICKUP_S);
        for row in 0..N {
            if let Some(inside) = self.inside(foreseen, row) {
                if new { self.pickup.add(inside) } else { self.flight.add(inside) }
            }
        }
        self.told.push_front(foreseen.std);
        self.told.truncate(MOST_WAITING);
    }

    /// Whether the error of `row` lies in the band of one lead ago; `None` if there is no error, no lead or no band.
    fn inside(&self, foreseen: &Foreseen, row: usize) -> Option<bool> {
        let age = (foreseen.lead_s[row] / TICK_S).round() as usize;
        let std = self.told.get(age.checked_sub(1)?)?.get(row)?;
        Some(foreseen.error.get(row)?.abs() <= BAND_90 * std)
    }

    /// Share in the band, without the second after the grasp.
    pub(super) fn flight(&self) -> Option<f64> {
        self.flight.value()
    }

    /// Share in the band in the second after the grasp.
    pub(super) fn pickup(&self) -> Option<f64> {
        self.pickup.value()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::fixture;
    use twin_core::notation::Coords;
    use twin_core::tick::Event;

    #[test]
    fn an_error_is_compared_with_the_band_that_was_told_one_lead_before() {
        let mut coverage = Coverage::default();
        for t in 0..10_u32 {
            let mut tick = fixture::tick(u64::from(t));
            tick.events = Vec::new();
            if t == 8 {
                tick.events.push(Event::new(EventKind::Grasp, "gripped"));
            }
            let foreseen = tick.foreseen.as_mut().unwrap();
            foreseen.lead_s = Coords::repeat(0.03);
            foreseen.std = Coords::repeat(f64::from(t)).into();
            // Three ticks ago the band was BAND_90 (t - 3); the error is within it only for even ticks.
            let half = BAND_90 * (f64::from(t) - 3.0);
            let error = if t % 2 == 0 { half - 0.01 } else { half + 0.01 };
            foreseen.error = Coords::repeat(error).into();
            coverage.add(&tick);
        }
        // Ticks 3 to 7 have a band: 4 and 6 of them are inside. At 3 the band has no width.
        assert_eq!(coverage.flight(), Some(0.4));
        assert_eq!(coverage.pickup(), Some(0.5), "8 inside, 9 outside");
    }
}
