//! The channels of a telemetry row: the name of each number and its source in a [`Tick`].

mod foresight;
mod world;
mod of_flight;

use std::sync::Arc;

use crate::server::mirrored::NOT_IN_FORCE;
use crate::server::protocol::ChannelInfo;
use twin_core::notation::{COORDINATE_NAMES, Coords, KnownCoords, MAX_ROTORS, position};
use twin_core::residual::PredictorInfo;
use twin_core::tick::Tick;
use twin_core::tuning::Tuning;
use twin_scenario::ActuatorLimits;

/// Reads the value of a channel; `None` is unknown.
type Take = Box<dyn Fn(&RowSource) -> Option<f64> + Send + Sync>;

/// The data from which a row is made.
#[derive(Clone, Copy, Debug)]
pub struct RowSource<'a> {
    /// The tick.
    pub tick: &'a Tick,
    /// Values in force while it was flown.
    pub tuning: &'a Tuning,
    /// Eigenvalues of the adapter's covariance, largest first.
    pub spectrum: &'a [f64],
}

/// The channels of one flight, in the order of a row.
pub struct Channels {
    infos: Arc<Vec<ChannelInfo>>,
    takes: Vec<Take>,
    horizon_ticks: u32,
}

impl Channels {
    /// The channels of a flight with `rotors` rotors, these actuator limits and this predictor.
    pub fn new(rotors: usize, limits: &ActuatorLimits, predictor: &PredictorInfo) -> Self {
        let mut channels = Builder { infos: Vec::new(), takes: Vec::new(), scale: predictor.scale };
        channels.tracking();
        channels.residual();
        channels.foresight();
        channels.adapter();
        channels.spectrum();
        channels.attention(&predictor.attends);
        channels.robust();
        channels.actuators(rotors.min(MAX_ROTORS), limits);
        channels.gripper();
        channels.world();
        channels.forces();
        let horizon_ticks = predictor.horizon as u32;
        Self { infos: Arc::new(channels.infos), takes: channels.takes, horizon_ticks }
    }

    /// How far the predictor looks into the future, ticks.
    pub(super) fn horizon_ticks(&self) -> u32 {
        self.horizon_ticks
    }

    /// The channels of a mirrored flight: its reference is the expected pose, and `scale` is the standard deviation of its residual, N and
    /// N m.
    pub fn mirrored(rotors: usize, scale: &Coords) -> Self {
        let limits = ActuatorLimits {
            rotor_thrust_n: [f64::NEG_INFINITY, f64::INFINITY],
            joint_torque_n_m: [None; 2],
        };
        let predictor = PredictorInfo { scale: *scale, ..PredictorInfo::default() };
        let mut channels = Self::new(rotors, &limits, &predictor);
        for (info, take) in Arc::make_mut(&mut channels.infos).iter_mut().zip(&mut channels.takes) {
            info.limits = None;
            if NOT_IN_FORCE.contains(&info.group.as_str()) {
                *take = Box::new(|_| None);
            }
            info.label = info.label.replace("desired", "expected").replace("error", "divergence");
        }
        channels
    }

    /// Names, groups and units.
    pub fn infos(&self) -> &Arc<Vec<ChannelInfo>> {
        &self.infos
    }

    /// The row of a tick. Only here an unknown number becomes NaN.
    pub fn row(&self, sample: &RowSource) -> Arc<[f32]> {
        self.takes.iter().map(|take| take(sample).map_or(f32::NAN, |value| value as f32)).collect()
    }
}

struct Builder {
    infos: Vec<ChannelInfo>,
    takes: Vec<Take>,
    /// Unit of z-scored residuals, N and N m.
    scale: Coords,
}

/// The description of a channel that belongs to no coordinate and has no limits.
fn plain(group: &str, unit: &str, name: &str, label: &str) -> ChannelInfo {
    ChannelInfo {
        name: name.to_owned(),
        label: label.to_owned(),
        group: group.to_owned(),
        unit: unit.to_owned(),
        row: None,
        limits: None,
        z_scale: None,
        weight: None,
    }
}

impl Builder {
    fn add<V: Into<Option<f64>>>(
        &mut self,
        group: &str,
        unit: &str,
        name: &str,
        label: &str,
        take: impl Fn(&Tick, &Tuning) -> V + Send + Sync + 'static,
    ) -> &mut ChannelInfo {
        self.add_sampled(group, unit, name, label, move |sample| take(sample.tick, sample.tuning))
    }

    fn add_sampled<V: Into<Option<f64>>>(
        &mut self,
        group: &str,
        unit: &str,
        name: &str,
        label: &str,
        take: impl Fn(&RowSource) -> V + Send + Sync + 'static,
    ) -> &mut ChannelInfo {
        self.takes.push(Box::new(move |sample| take(sample).into()));
        self.infos.push_mut(plain(group, unit, name, label))
    }

    /// One channel per coordinate.
    fn rows(
        &mut self,
        group: &str,
        units: [&str; 2],
        stem: &str,
        label: &str,
        take: impl Fn(&Tick) -> Option<KnownCoords> + Copy + Send + Sync + 'static,
    ) {
        for (index, row) in COORDINATE_NAMES.iter().enumerate() {
            let unit = units[usize::from(index >= 3)];
            let name = format!("{stem}.{row}");
            let scale = self.scale[index];
            let info = self.add(group, unit, &name, &format!("{label} {row}"), move |tick, _| {
                take(tick)?.get(index)
            });
            info.row = Some((*row).to_owned());
            info.z_scale = (units == OF_RESIDUAL).then_some(scale);
        }
    }

    fn tracking(&mut self) {
        const UNITS: [&str; 2] = ["m", "rad"];
        self.rows("tracking", UNITS, "chi", "measured", |tick| Some(tick.measurement.chi));
        self.rows("tracking", UNITS, "chi_des", "desired", |tick| Some(tick.reference.chi_des));
        self.rows("tracking", UNITS, "error", "error", |tick| Some(tick.control.error));
        self.add("tracking", "m", "position_error_m", "position error", |tick, _| {
            let error = &tick.control.error;
            (error.known()[..3] == [true; 3]).then(|| position(error).norm())
        });
    }

    fn residual(&mut self) {
        const GROUP: &str = "residual";
        const UNITS: [&str; 2] = OF_RESIDUAL;
        self.rows(GROUP, UNITS, "residual", "measured r", |tick| Some(tick.residual));
        self.rows(GROUP, UNITS, "base", "base forecast", |t| t.forecast.base.first().copied());
        self.rows(GROUP, UNITS, "adapted", "adapted forecast", |tick| Some(tick.adapted.r_hat));
        self.rows(GROUP, UNITS, "r_hat", "estimate in force", |tick| {
            // Where the residual is unknown, the loop uses a stand-in as estimate: it is no measurement, so it is left out.
            Some(KnownCoords::from(tick.setpoint.r_hat).only(tick.residual.known()))
        });
    }

    fn adapter(&mut self) {
        const GROUP: &str = "adapter";
        self.rows(GROUP, ["", ""], "innovation", "innovation", |t| Some(t.adapted.innovation));
        self.rows(GROUP, OF_RESIDUAL, "bias", "bias", |tick| {
            Some(KnownCoords::from(tick.adapted.bias).only(tick.adapted.r_hat.known()))
        });
        self.add(GROUP, "", "innovation_mean", "mean innovation", |tick, _| {
            tick.adapted.innovation_mean_norm
        });
        self.add(GROUP, "", "reset_threshold", "δ", |_, tuning| tuning.adapter.reset_threshold);
        self.add(GROUP, "", "reset", "reset", |tick, _| flag(tick.adapted.reset));
        self.add(GROUP, "", "covariance_trace", "tr Σ", |tick, _| tick.adapted.covariance_trace);
        self.add(GROUP, "", "gain_norm", "‖K‖", |tick, _| tick.adapted.gain_norm);
        self.add(GROUP, "", "weight_norm", "‖W‖", |tick, _| tick.adapted.weight_norm);
        self.add(GROUP, "", "regime_norm", "‖g′‖", |tick, _| {
            tick.forecast.regime.iter().map(|g| g * g).sum::<f64>().sqrt()
        });
        self.add(GROUP, "", "frozen", "frozen", |tick, _| flag(tick.adapted.frozen));
    }

    fn spectrum(&mut self) {
        let mut add = |name: &str, label: &str, take: fn(&[f64]) -> Option<&f64>| {
            self.add_sampled("adapter", "", name, label, move |sample| {
                take(sample.spectrum).copied()
            });
        };
        add("covariance_eig_max", "largest eigenvalue of Σ", <[f64]>::first);
        add("covariance_eig_median", "median eigenvalue of Σ", |v| v.get(v.len() / 2));
        add("covariance_eig_min", "smallest eigenvalue of Σ", <[f64]>::last);
    }

    /// One channel per input channel of the network; the network attends most to the channel with the largest value.
    fn attention(&mut self, attends: &[String]) {
        for (index, channel) in attends.iter().enumerate() {
            self.add("attention", "", &format!("attention.{channel}"), channel, move |tick, _| {
                tick.forecast.attention.get(index).copied()
            });
        }
    }

    fn robust(&mut self) {
        self.add("robust", "", "robust_gain", "σ̂", |tick, _| tick.setpoint.robust_gain);
        self.add("robust", "", "sliding_norm", "‖s‖", |tick, _| tick.setpoint.sliding_norm);
    }

    fn actuators(&mut self, rotors: usize, limits: &ActuatorLimits) {
        const GROUP: &str = "actuators";
        for rotor in 0..rotors {
            let info = self.add(
                GROUP,
                "N",
                &format!("rotor.{rotor}"),
                &format!("rotor {}", rotor + 1),
                move |tick, _| thrusts(tick)[rotor],
            );
            info.limits = Some(limits.rotor_thrust_n);
        }
        self.add(GROUP, "N", "thrust_total_n", "total thrust", move |tick, _| {
            thrusts(tick).iter().take(rotors).sum::<f64>()
        });
        for joint in 0..2 {
            let name = format!("joint_torque.{}", joint + 1);
            let info = self.add(
                GROUP,
                "N m",
                &name,
                &format!("joint {} torque", joint + 1),
                move |tick, _| tick.actuators.joint_torque_n_m[joint],
            );
            info.limits = limits.joint_torque_n_m[joint].map(|most| [-most, most]);
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
            tick.truth.as_ref().map(|truth| truth.grip_force_n)
        });
    }
}

/// Units of a residual: of a force, and of a moment.
const OF_RESIDUAL: [&str; 2] = ["N", "N m"];

/// Thrust of each rotor, N: the true one if it is known, otherwise the commanded one.
fn thrusts(tick: &Tick) -> &[f64] {
    let asked = &tick.actuators.rotor_thrust_n;
    tick.truth.as_ref().map_or(asked, |truth| &truth.rotor_thrust_n)
}

fn flag(on: bool) -> f64 {
    f64::from(u8::from(on))
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::control::{Gains, Preset};
    use twin_core::residual::lra;
    use twin_record::fixture;

    fn tuning() -> Tuning {
        Tuning { gains: Gains::preset(Preset::Tuned), adapter: lra::Settings::default() }
    }

    pub(super) fn value(channels: &Channels, tick: &Tick, name: &str) -> f32 {
        let index = channels.infos().iter().position(|info| info.name == name).expect(name);
        row(channels, tick)[index]
    }

    fn row(channels: &Channels, tick: &Tick) -> Arc<[f32]> {
        channels.row(&RowSource { tick, tuning: &tuning(), spectrum: &[9.0, 4.0, 1.0] })
    }

    pub(super) fn channels(rotors: usize) -> Channels {
        let limits =
            ActuatorLimits { rotor_thrust_n: [0.3, 15.0], joint_torque_n_m: [Some(3.0), None] };
        Channels::new(rotors, &limits, &predictor())
    }

    fn predictor() -> PredictorInfo {
        PredictorInfo {
            scale: Coords::from_fn(|row, _| 0.5 + row as f64),
            attends: vec!["chi.z".to_owned(), "tau.q2".to_owned()],
            ..PredictorInfo::default()
        }
    }

    #[test]
    fn names_are_unique_and_a_row_has_one_number_for_each() {
        let channels = channels(4);
        let mut names: Vec<&str> = channels.infos().iter().map(|info| info.name.as_str()).collect();
        assert_eq!(row(&channels, &fixture::tick(3)).len(), names.len());
        names.sort_unstable();
        names.dedup();
        // 21 stems of 8 coordinates, 15 single channels, 3 of the spectrum, 2 of the attention, 3 of the wind, 4 rotors, 2 joints, 14 forces.
        assert_eq!(names.len(), 21 * 8 + 15 + 3 + 2 + 3 + 4 + 2 + 3 * 14);
    }

    #[test]
    fn each_number_comes_from_its_own_place_in_the_tick() {
        let (channels, tick) = (channels(4), fixture::tick(3));
        let places = [
            ("chi.z", tick.measurement.chi[2]),
            ("chi_des.psi", tick.reference.chi_des[5]),
            ("error.q2", tick.control.error[7]),
            ("residual.x", tick.residual[0]),
            ("base.y", tick.forecast.base[0][1]),
            ("adapted.theta", tick.adapted.r_hat[4]),
            ("innovation.phi", tick.adapted.innovation[3]),
            ("bias.z", tick.adapted.bias[2]),
            ("innovation_mean", tick.adapted.innovation_mean_norm),
            ("reset_threshold", 3.2),
            ("covariance_trace", 32.0),
            ("gain_norm", 0.25),
            ("weight_norm", 0.75),
            ("robust_gain", tick.setpoint.robust_gain),
            ("sliding_norm", tick.setpoint.sliding_norm),
            ("r_hat.z", tick.setpoint.r_hat[2]),
            ("covariance_eig_max", 9.0),
            ("covariance_eig_median", 4.0),
            ("covariance_eig_min", 1.0),
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
        let channels = channels(2);
        assert!(value(&channels, &tick, "grip_force_n").is_nan());
        assert!(value(&channels, &tick, "wind.y").is_nan());
        assert_eq!(value(&channels, &tick, "rotor.1").to_bits(), 7.0_f32.to_bits());
    }

    #[test]
    fn attention_and_regime_are_those_of_the_forecast_and_unknown_without_it() {
        let mut tick = fixture::tick(3);
        tick.forecast.attention = vec![0.25, 0.75];
        tick.forecast.regime = vec![3.0, -4.0];
        assert_eq!(value(&channels(4), &tick, "attention.tau.q2").to_bits(), 0.75_f32.to_bits());
        assert_eq!(value(&channels(4), &tick, "regime_norm").to_bits(), 5.0_f32.to_bits());
        tick.forecast.attention.clear();
        assert!(value(&channels(4), &tick, "attention.chi.z").is_nan());
    }

    #[test]
    fn limits_and_scales_stand_at_the_channels_they_belong_to() {
        let channels = channels(2);
        let info = |name: &str| channels.infos().iter().find(|info| info.name == name).unwrap();
        assert_eq!(info("rotor.1").limits, Some([0.3, 15.0]));
        assert_eq!(info("joint_torque.1").limits, Some([-3.0, 3.0]));
        assert_eq!(info("joint_torque.2").limits, None);
        assert_eq!(info("residual.z").z_scale, Some(2.5));
        assert_eq!(info("innovation.z").z_scale, None);
        assert_eq!(info("fan_25.z").z_scale, Some(2.5));
        assert_eq!(info("lead_s.z").z_scale, None);
    }
}
