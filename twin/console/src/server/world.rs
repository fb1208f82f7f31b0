//! Keeps the payload, the wind and the aerodynamic effects of one flight as the scenario and operators last set them.

use crate::server::protocol::StateInfo;
use twin_core::source::Disturbance;
use twin_core::source::EFFECTS;
use twin_scenario::Settings;

/// The world as the scenario and operators last set it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct World {
    payload_kg: Option<f64>,
    wind_m_s: [f64; 3],
    effects_off: Vec<String>,
    /// Changes that the scenario makes later, with their times in s; latest first.
    schedule: Vec<(f64, Disturbance)>,
}

impl World {
    /// The world at the start of a scenario.
    pub(super) fn new(settings: &Settings) -> Self {
        let mut schedule: Vec<(f64, Disturbance)> =
            settings.disturbances.iter().map(|d| (d.at_s, d.disturbance.clone())).collect();
        schedule.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mass_kg = settings.payload.mass_kg;
        let plant = settings.plant();
        let off = EFFECTS.into_iter().filter(|name| plant.effect(name) == Some(false));
        Self {
            payload_kg: (mass_kg > 0.0).then_some(mass_kg),
            wind_m_s: settings.wind.velocity_m_s,
            effects_off: off.map(str::to_owned).collect(),
            schedule,
        }
    }

    /// Applies the changes that the scenario makes up to `t_s`.
    pub(super) fn advance(&mut self, t_s: f64) {
        while self.schedule.last().is_some_and(|(at_s, _)| *at_s <= t_s) {
            if let Some((_, disturbance)) = self.schedule.pop() {
                self.change(&disturbance);
            }
        }
    }

    /// Applies a change.
    pub(super) fn change(&mut self, disturbance: &Disturbance) {
        match disturbance {
            Disturbance::PayloadMass { kg } => self.payload_kg = self.payload_kg.map(|_| *kg),
            Disturbance::Wind { velocity_m_s } => self.wind_m_s = *velocity_m_s,
            Disturbance::Effect { name, on } => {
                self.effects_off.retain(|off| off != name);
                if !on {
                    self.effects_off.push(name.clone());
                }
            }
            Disturbance::Push { .. } | Disturbance::DropPayload | Disturbance::Failure { .. } => {}
        }
    }

    /// Writes the world into the settings of a scenario.
    pub(super) fn put_into(&self, settings: &mut Settings) {
        settings.payload.mass_kg = self.payload_kg.unwrap_or(0.0);
        settings.wind.velocity_m_s = self.wind_m_s;
        for name in EFFECTS {
            settings.switch_effect(name, !self.effects_off.iter().any(|off| off == name));
        }
    }

    /// Writes the world into the state for clients.
    pub(super) fn describe(&self, state: &mut StateInfo) {
        state.payload_kg = self.payload_kg;
        state.wind_m_s = self.wind_m_s;
        state.effects_off.clone_from(&self.effects_off);
    }
}
