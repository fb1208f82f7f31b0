//! Counts the ticks with saturated rotors and says once when they are many.

use crate::notation::TICK_S;
use crate::tick::{Event, EventKind};

/// Saturation of the rotors is worth an event once it has lasted so long in all, s.
pub const LONG_S: f64 = 1.0;

/// The ticks with saturated rotors so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SaturationWatch {
    ticks: u64,
}

impl SaturationWatch {
    /// Counts one tick; gives an event at the tick that makes [`LONG_S`] full.
    pub(super) fn step(&mut self, saturated: bool) -> Option<Event> {
        let before_s = self.ticks as f64 * TICK_S;
        self.ticks += u64::from(saturated);
        let now_s = self.ticks as f64 * TICK_S;
        (before_s < LONG_S && now_s >= LONG_S).then(|| {
            let text = format!(
                "rotors saturated for {LONG_S:.0} s in all: they do not give the force and moment that the loop asks for"
            );
            Event::new(EventKind::Saturation, text)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_event_tells_the_first_second_of_saturation_with_or_without_gaps() {
        for gaps in [1, 3] {
            let mut watch = SaturationWatch::default();
            let told: Vec<u64> =
                (0..900).filter(|tick| watch.step(tick % gaps == 0).is_some()).collect();
            // The hundredth saturated tick, and no other.
            assert_eq!(told, [99 * gaps], "every {gaps}th tick is saturated");
        }
        let mut watch = SaturationWatch::default();
        assert!((0..99).all(|_| watch.step(true).is_none()));
    }
}
