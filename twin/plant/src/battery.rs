//! The battery: voltage that sags with load and falls with charge.
//!
//! In: electrical power of all rotors. Out: voltage as a share of the reference, and the current limit of a rotor. State: charge and
//! polarisation.

use super::settings::BatterySettings;
use twin_core::elementary::{exp, squared};

/// Seconds of an hour.
const HOUR_S: f64 = 3600.0;

/// Smallest voltage as a share of the reference; beyond it the battery has collapsed and the model ends.
const LEAST_SHARE: f64 = 0.3;

/// Charge and polarisation of the battery.
#[derive(Clone, Debug)]
pub(super) struct Battery {
    pub(super) settings: BatterySettings,
    /// Charge per capacity.
    charge: f64,
    /// Voltage over the polarisation, V.
    polarisation_v: f64,
    /// Voltage at the terminals, V.
    terminal_v: f64,
    dt_s: f64,
}

impl Battery {
    /// The battery at the start of a flight, after it has carried `power_w` for a long time.
    pub(super) fn new(settings: &BatterySettings, power_w: f64, dt_s: f64) -> Self {
        let mut this = Self {
            settings: *settings,
            charge: settings.charge,
            polarisation_v: 0.0,
            terminal_v: settings.reference_v,
            dt_s,
        };
        // Voltage and current depend on each other; a few rounds settle both.
        for _ in 0..8 {
            let current_a = this.current_a(power_w);
            this.polarisation_v = current_a * settings.polarisation_ohm;
            this.terminal_v = this.loaded_v(current_a);
        }
        this
    }

    /// Advances by a step in which the rotors take `power_w` of mechanical power.
    pub(super) fn step(&mut self, power_w: f64) {
        let s = self.settings;
        let current_a = self.current_a(power_w);
        self.charge -= current_a * self.dt_s / (HOUR_S * s.capacity_a_h);
        let settled_v = current_a * s.polarisation_ohm;
        self.polarisation_v +=
            (settled_v - self.polarisation_v) * (1.0 - exp(-self.dt_s / s.polarisation_s));
        self.terminal_v = self.loaded_v(current_a);
    }

    /// Speed of a rotor per commanded speed. A controller without feedback applies a share of the voltage, and the speed follows it.
    pub(super) fn speed_share(&self) -> f64 {
        if self.settings.on { self.terminal_v / self.settings.reference_v } else { 1.0 }
    }

    /// Largest mechanical power of a rotor, W.
    pub(super) fn rotor_power_w(&self) -> f64 {
        let s = self.settings;
        if s.on { s.rotor_current_a * self.terminal_v * s.efficiency } else { f64::INFINITY }
    }

    fn current_a(&self, power_w: f64) -> f64 {
        power_w.max(0.0) / (self.settings.efficiency * self.terminal_v)
    }

    fn loaded_v(&self, current_a: f64) -> f64 {
        let s = self.settings;
        let open_v = s.cells * cell_v(self.charge);
        let loaded_v = open_v - current_a * s.resistance_ohm - self.polarisation_v;
        loaded_v.max(LEAST_SHARE * s.reference_v)
    }
}

/// Open-circuit voltage of a lithium cell, V, at `charge` per capacity. Source: Chen and Rincón-Mora, "Accurate electrical battery model
/// capable of predicting runtime and I-V performance", IEEE Transactions on Energy Conversion 21 (2006), equation (2).
pub(super) fn cell_v(charge: f64) -> f64 {
    let c = charge.clamp(0.0, 1.0);
    -1.031 * exp(-35.0 * c) + 3.685 + 0.2156 * c - 0.1178 * squared(c) + 0.3201 * c * squared(c)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> BatterySettings {
        BatterySettings {
            on: true,
            cells: 6.0,
            capacity_a_h: 5.0,
            charge: 0.9,
            resistance_ohm: 0.02,
            polarisation_ohm: 0.01,
            polarisation_s: 30.0,
            reference_v: 23.7,
            efficiency: 0.75,
            rotor_current_a: 20.0,
        }
    }

    #[test]
    fn a_full_cell_has_the_published_voltage_and_an_empty_one_collapses() {
        assert!((cell_v(1.0) - 4.103).abs() < 1e-3);
        assert!((cell_v(0.5) - 3.8034).abs() < 1e-3);
        assert!((cell_v(0.0) - 2.654).abs() < 1e-3);
    }

    #[test]
    fn a_load_lowers_the_voltage_by_its_resistance_at_once_and_further_with_time() {
        let mut battery = Battery::new(&settings(), 0.0, 1e-3);
        let rest_v = battery.terminal_v;
        assert!((rest_v - 6.0 * cell_v(0.9)).abs() < 1e-12);
        let power_w = 0.75 * rest_v * 10.0;
        battery.step(power_w);
        // 10 A through 0.02 ohm; one millisecond moves charge and polarisation by less than a millivolt.
        assert!((rest_v - battery.terminal_v - 0.2).abs() < 1e-3);
        (0..120_000).for_each(|_| battery.step(power_w));
        let fallen_v = 6.0 * (cell_v(0.9) - cell_v(battery.charge));
        let lasting_v = rest_v - battery.terminal_v - fallen_v;
        // The current grows as the voltage falls: 10.3 A; after four time constants 98 % of the polarisation is there.
        assert!((lasting_v - 10.3 * (0.02 + 0.98 * 0.01)).abs() < 0.01, "{lasting_v}");
        // Two minutes at 10.2 A of 5 A h.
        assert!((0.9 - battery.charge - 10.2 * 120.0 / 18_000.0).abs() < 1e-3);
    }

    #[test]
    fn a_battery_that_is_off_changes_nothing() {
        let battery = Battery::new(&BatterySettings { on: false, ..settings() }, 300.0, 1e-3);
        assert_eq!(battery.speed_share().to_bits(), 1.0_f64.to_bits());
        assert!(battery.rotor_power_w().is_infinite());
    }
}
