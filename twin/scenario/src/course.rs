//! How well a flight without a payload to place kept to its reference: position error, contact, saturation.

use super::rms::Rms;
use twin_core::flight::LONG_SATURATION_S;
use twin_core::notation::TICK_S;
use twin_core::tick::{Tick, Truth};

/// Errors before this time belong to the start and are left out, s.
pub(super) const FROM_S: f64 = 2.0;

/// A vehicle in contact for so long rests on a surface; a touch is shorter, s.
const REST_S: f64 = 0.5;

/// Weakest contact force that counts, N.
const TOUCH_N: f64 = 0.1;

/// Accumulates a flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Course {
    whole: Rms,
    settled: Rms,
    ticks: u64,
    saturated: u64,
    /// Ticks since when the vehicle is in contact without a break.
    touching: u64,
}

impl Course {
    /// Adds a tick with the true state.
    pub(super) fn add(&mut self, tick: &Tick, truth: &Truth) {
        let error = truth.chi - *tick.reference.chi_des;
        let position_squared = error.fixed_rows::<3>(0).norm_squared();
        self.whole.add(position_squared);
        if tick.measurement.t_s >= FROM_S {
            self.settled.add(position_squared);
        }
        self.ticks += 1;
        self.saturated += u64::from(tick.measurement.saturated);
        self.touching = if truth.collision_force_n > TOUCH_N { self.touching + 1 } else { 0 };
    }

    /// Root mean square of the position error from 2 s on, or over the whole of a shorter flight, m.
    pub(super) fn error_m(&self) -> f64 {
        self.settled.value().or(self.whole.value()).unwrap_or(0.0)
    }

    /// True if the vehicle lies on a surface.
    pub(super) fn rests(&self) -> bool {
        self.touching as f64 * TICK_S >= REST_S
    }

    /// The share of the flight with saturated rotors as the end of a sentence; empty unless they were saturated for long.
    pub(super) fn saturation(&self) -> String {
        let saturated_s = self.saturated as f64 * TICK_S;
        if saturated_s < LONG_SATURATION_S {
            return String::new();
        }
        let share = 100.0 * self.saturated as f64 / self.ticks.max(1) as f64;
        format!("; rotors saturated for {saturated_s:.1} s ({share:.0} % of the flight)")
    }
}
