//! The numbers of a telemetry row: what each is called and where in a [`Tick`] it comes from.

use std::sync::Arc;

use crate::notation::{Coords, MAX_ROTORS, ROWS, position};
use crate::server::protocol::ChannelInfo;
use crate::tick::Tick;
use crate::tuning::Tuning;

type Take = Box<dyn Fn(&Tick, &Tuning) -> f64 + Send + Sync>;

/// The channels of one flight, in the order of a row.
pub struct Channels {
    infos: Arc<Vec<ChannelInfo>>,
    takes: Vec<Take>,
}

impl Channels {
    /// The channels of a vehicle with `rotors` rotors.
    pub fn new(rotors: usize) -> Self {
        let mut channels = Builder { infos: Vec::new(), takes: Vec::new() };
        channels.tracking();
        channels.residual();
        channels.adapter();
        channels.robust();
        channels.actuators(rotors.min(MAX_ROTORS));
        channels.gripper();
        Self { infos: Arc::new(channels.infos), takes: channels.takes }
    }

    /// Names, groups and units.
    pub fn infos(&self) -> &Arc<Vec<ChannelInfo>> {
        &self.infos
    }

    /// The row of a tick flown with `tuning`; NaN is unknown.
    pub fn row(&self, tick: &Tick, tuning: &Tuning) -> Arc<[f32]> {
        self.takes.iter().map(|take| take(tick, tuning) as f32).collect()
    }
}

struct Builder {
    infos: Vec<ChannelInfo>,
    takes: Vec<Take>,
}

impl Builder {
    fn add(
        &mut self,
        group: &str,
        unit: &str,
        name: &str,
        label: &str,
        take: impl Fn(&Tick, &Tuning) -> f64 + Send + Sync + 'static,
    ) {
        self.infos.push(ChannelInfo {
            name: name.to_owned(),
            label: label.to_owned(),
            group: group.to_owned(),
            unit: unit.to_owned(),
            row: None,
        });
        self.takes.push(Box::new(take));
    }

    /// One channel per coordinate.
    fn rows(
        &mut self,
        group: &str,
        units: [&str; 2],
        stem: &str,
        label: &str,
        take: fn(&Tick) -> Option<&Coords>,
    ) {
        for (index, row) in ROWS.iter().enumerate() {
            let unit = units[usize::from(index >= 3)];
            let name = format!("{stem}.{row}");
            self.add(group, unit, &name, &format!("{label} {row}"), move |tick, _| {
                take(tick).map_or(f64::NAN, |coords| coords[index])
            });
            if let Some(info) = self.infos.last_mut() {
                info.row = Some((*row).to_owned());
            }
        }
    }

    fn tracking(&mut self) {
        const UNITS: [&str; 2] = ["m", "rad"];
        self.rows("tracking", UNITS, "chi", "measured", |tick| Some(&tick.measurement.chi));
        self.rows("tracking", UNITS, "chi_des", "desired", |tick| Some(&tick.reference.chi_des));
        self.rows("tracking", UNITS, "error", "error", |tick| Some(&tick.control.error));
        self.add("tracking", "m", "position_error_m", "position error", |tick, _| {
            position(&tick.control.error).norm()
        });
    }

    fn residual(&mut self) {
        const UNITS: [&str; 2] = ["N", "N m"];
        self.rows("residual", UNITS, "residual", "measured r", |tick| Some(&tick.residual));
        self.rows("residual", UNITS, "base", "base forecast", |tick| tick.forecast.base.first());
        self.rows("residual", UNITS, "adapted", "adapted forecast", |tick| {
            Some(&tick.adapted.r_hat)
        });
    }

    fn adapter(&mut self) {
        const GROUP: &str = "adapter";
        self.rows(GROUP, ["", ""], "innovation", "innovation", |tick| {
            Some(&tick.adapted.innovation)
        });
        self.add(GROUP, "", "innovation_mean", "mean innovation", |tick, _| {
            tick.adapted.innovation_mean_norm
        });
        self.add(GROUP, "", "reset_threshold", "δ", |_, tuning| tuning.adapter.reset_threshold);
        self.add(GROUP, "", "reset", "reset", |tick, _| flag(tick.adapted.reset));
        self.add(GROUP, "", "covariance_trace", "tr Σ", |tick, _| tick.adapted.covariance_trace);
        self.add(GROUP, "", "gain_norm", "‖K‖", |tick, _| tick.adapted.gain_norm);
        self.add(GROUP, "", "weight_norm", "‖W‖", |tick, _| tick.adapted.weight_norm);
        self.add(GROUP, "", "frozen", "frozen", |tick, _| flag(tick.adapted.frozen));
    }

    fn robust(&mut self) {
        self.add("robust", "", "robust_gain", "σ̂", |tick, _| tick.setpoint.robust_gain);
        self.add("robust", "", "sliding_norm", "‖s‖", |tick, _| tick.setpoint.sliding_norm);
    }

    fn actuators(&mut self, rotors: usize) {
        const GROUP: &str = "actuators";
        for rotor in 0..rotors {
            self.add(
                GROUP,
                "N",
                &format!("rotor.{rotor}"),
                &format!("rotor {}", rotor + 1),
                move |tick, _| {
                    let asked = &tick.actuators.rotor_thrust_n;
                    tick.truth.as_ref().map_or(asked, |truth| &truth.rotor_thrust_n)[rotor]
                },
            );
        }
        for joint in 0..2 {
            let name = format!("joint_torque.{}", joint + 1);
            self.add(
                GROUP,
                "N m",
                &name,
                &format!("joint {} torque", joint + 1),
                move |tick, _| tick.actuators.joint_torque_n_m[joint],
            );
        }
        self.add(GROUP, "", "saturated", "saturated", |tick, _| {
            flag(tick.measurement.saturated || tick.actuators.saturated)
        });
    }

    fn gripper(&mut self) {
        self.add("gripper", "m", "opening_m", "opening", |tick, _| {
            tick.measurement.gripper.opening_m
        });
        self.add("gripper", "N", "grip_force_n", "grip force, both pads", |tick, _| {
            tick.truth.as_ref().map_or(f64::NAN, |truth| truth.grip_force_n)
        });
    }
}

fn flag(on: bool) -> f64 {
    f64::from(u8::from(on))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{Gains, Preset};
    use crate::mirror::fixture;
    use crate::residual::lra;

    fn tuning() -> Tuning {
        Tuning { gains: Gains::preset(Preset::Tuned), adapter: lra::Settings::default() }
    }

    fn value(channels: &Channels, tick: &Tick, name: &str) -> f32 {
        let index = channels.infos().iter().position(|info| info.name == name).expect(name);
        channels.row(tick, &tuning())[index]
    }

    #[test]
    fn names_are_unique_and_a_row_has_one_number_for_each() {
        let channels = Channels::new(4);
        let mut names: Vec<&str> = channels.infos().iter().map(|info| info.name.as_str()).collect();
        assert_eq!(channels.row(&fixture::tick(3), &tuning()).len(), names.len());
        names.sort_unstable();
        names.dedup();
        // 7 stems of 8 rows, 13 single ones, 4 rotors, 2 joints.
        assert_eq!(names.len(), 7 * 8 + 13 + 4 + 2);
    }

    #[test]
    fn each_number_comes_from_its_own_place_in_the_tick() {
        let (channels, tick) = (Channels::new(4), fixture::tick(3));
        let places = [
            ("chi.z", tick.measurement.chi[2]),
            ("chi_des.psi", tick.reference.chi_des[5]),
            ("error.q2", tick.control.error[7]),
            ("residual.x", tick.residual[0]),
            ("base.y", tick.forecast.base[0][1]),
            ("adapted.theta", tick.adapted.r_hat[4]),
            ("innovation.phi", tick.adapted.innovation[3]),
            ("innovation_mean", tick.adapted.innovation_mean_norm),
            ("reset_threshold", 3.2),
            ("covariance_trace", 32.0),
            ("gain_norm", 0.25),
            ("weight_norm", 0.75),
            ("robust_gain", tick.setpoint.robust_gain),
            ("sliding_norm", tick.setpoint.sliding_norm),
            ("rotor.3", 8.0),
            ("joint_torque.2", -0.25),
            ("saturated", 1.0),
            ("opening_m", 0.0625),
            ("grip_force_n", 20.5),
        ];
        for (name, wanted) in places {
            assert_eq!(
                value(&channels, &tick, name).to_bits(),
                (wanted as f32).to_bits(),
                "{name}"
            );
        }
    }

    #[test]
    fn what_only_the_simulation_knows_is_unknown_in_a_real_flight() {
        let mut tick = fixture::tick(2);
        tick.truth = None;
        let channels = Channels::new(2);
        assert!(value(&channels, &tick, "grip_force_n").is_nan());
        assert_eq!(value(&channels, &tick, "rotor.1").to_bits(), 7.0_f32.to_bits());
    }
}
