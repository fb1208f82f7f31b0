//! The switches of the effects, by the names of [`twin_core::source::EFFECTS`].

use super::PlantSettings;

impl PlantSettings {
    /// The switch of the effect `name`; `None` if there is none of that name.
    pub fn effect_mut(&mut self, name: &str) -> Option<&mut bool> {
        let Self { aero, wind, vehicle, sensors, .. } = self;
        Some(match name {
            "inflow" => &mut aero.inflow,
            "flapping" => &mut aero.flapping,
            "rotor_drag" => &mut aero.rotor_drag,
            "body_drag" => &mut aero.body_drag,
            "ground_effect" => &mut aero.ground_effect,
            "recirculation" => &mut aero.recirculation,
            "downwash" => &mut aero.downwash,
            "unsteady" => &mut aero.unsteady,
            "wind" => &mut wind.on,
            "mismatch" => &mut vehicle.mismatch.on,
            "battery" => &mut vehicle.battery.on,
            "servo" => &mut vehicle.servo.on,
            "link" => &mut vehicle.link.on,
            "mocap_link" => &mut sensors.mocap_link.on,
            _ => return None,
        })
    }

    /// Whether the effect `name` is on; `None` if there is none of that name.
    pub fn effect(&self, name: &str) -> Option<bool> {
        self.clone().effect_mut(name).copied()
    }
}
