//! Sensors: motion capture with latency, IMU with bias and vibration, joint encoders. All noise is seeded.

use std::collections::VecDeque;

use nalgebra::{Matrix3, Vector2, Vector3};
use rand::SeedableRng;
use rand::distr::Distribution;
use rand_pcg::Pcg64;

use super::command_link::lateness;
use super::settings::SensorSettings;
use twin_core::elementary::{sin_cos, squared};
use twin_core::normal::StandardNormal;
use twin_core::notation::{GRAVITY_M_S2, PerRotor};
use twin_core::tick::PayloadReading;

/// The true state that the sensors measure.
#[derive(Clone, Copy, Debug)]
pub(super) struct KinematicState {
    pub(super) rotation: Matrix3<f64>,
    pub(super) position: Vector3<f64>,
    pub(super) velocity: Vector3<f64>,
    /// Angular velocity in the body frame, rad/s.
    pub(super) omega: Vector3<f64>,
    pub(super) joint: Vector2<f64>,
    pub(super) joint_dot: Vector2<f64>,
    pub(super) payload: Option<PayloadReading>,
}

/// A motion-capture sample that arrives after the latency.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mocap {
    pub(super) position: Vector3<f64>,
    pub(super) rotation: Matrix3<f64>,
    pub(super) payload: Option<PayloadReading>,
    /// Its age when it arrives, as the estimator believes, in steps of 1 ms.
    pub(super) age_steps: usize,
}

/// One IMU sample in the body frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Imu {
    /// Specific force, m/s².
    pub(super) accelerometer: Vector3<f64>,
    /// Angular rate, rad/s.
    pub(super) gyro: Vector3<f64>,
}

/// Failures of the sensors that are in force.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SensorFailures {
    /// Motion capture gives no sample.
    pub(super) mocap_lost: bool,
    /// Error that is added to the measured position of the base, m.
    pub(super) mocap_offset: Vector3<f64>,
    /// Error that is added to the specific force, m/s².
    pub(super) accelerometer_bias: Vector3<f64>,
    /// Error that is added to the angular rate, rad/s.
    pub(super) gyro_bias: Vector3<f64>,
    /// The encoders repeat their last angle.
    pub(super) encoders_dead: bool,
}

/// Sensors with their biases and the samples that have not arrived yet.
#[derive(Clone, Debug)]
pub(super) struct Sensors {
    /// Failures that are in force.
    pub(super) failures: SensorFailures,
    pub(super) settings: SensorSettings,
    rng: Pcg64,
    accelerometer_bias: Vector3<f64>,
    gyro_bias: Vector3<f64>,
    payload_offset: Vector3<f64>,
    vibration_phase: PerRotor,
    last_velocity: Option<Vector3<f64>>,
    mocap_phase: f64,
    under_way: VecDeque<(u64, Mocap)>,
    encoder_phase: f64,
    joint: Option<Vector2<f64>>,
    joint_dot: Vector2<f64>,
    step: u64,
    dt_s: f64,
}

impl Sensors {
    pub(super) fn new(settings: &SensorSettings, seed: u64, dt_s: f64) -> Self {
        let mut rng = Pcg64::seed_from_u64(seed ^ 0x5e45_0e5e);
        let mut vector = |std: f64| Vector3::from_fn(|_, _| std * normal(&mut rng));
        Self {
            accelerometer_bias: vector(settings.accelerometer_bias_m_s2),
            gyro_bias: vector(settings.gyro_bias_rad_s),
            payload_offset: vector(settings.payload_calibration_m),
            vibration_phase: std::array::from_fn(|i| 0.7 * i as f64),
            failures: SensorFailures::default(),
            settings: *settings,
            last_velocity: None,
            mocap_phase: 1.0,
            under_way: VecDeque::new(),
            encoder_phase: 1.0,
            joint: None,
            joint_dot: Vector2::zeros(),
            step: 0,
            dt_s,
            rng,
        }
    }

    /// An IMU sample: the specific force comes from the change of the base's velocity over the step, and vibration of the rotors,
    /// noise and bias are added.
    pub(super) fn imu(
        &mut self,
        state: &KinematicState,
        rotor_speed_rad_s: &PerRotor,
        hover_speed_rad_s: f64,
    ) -> Imu {
        let last = self.last_velocity.replace(state.velocity).unwrap_or(state.velocity);
        let acceleration =
            (state.velocity - last) / self.dt_s + Vector3::new(0.0, 0.0, GRAVITY_M_S2);
        let vibration = self.vibration(rotor_speed_rad_s, hover_speed_rad_s);
        let s = self.settings;
        let noise = Vector3::from_fn(|_, _| s.accelerometer_noise_m_s2 * normal(&mut self.rng));
        let gyro_noise = Vector3::from_fn(|_, _| s.gyro_noise_rad_s * normal(&mut self.rng));
        Imu {
            accelerometer: state.rotation.transpose() * acceleration
                + vibration
                + noise
                + self.accelerometer_bias
                + self.failures.accelerometer_bias,
            gyro: state.omega + gyro_noise + self.gyro_bias + self.failures.gyro_bias,
        }
    }

    /// Unbalanced rotors shake the frame at their turning frequency, with the square of their speed.
    fn vibration(&mut self, speed_rad_s: &PerRotor, hover_speed_rad_s: f64) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for (phase, speed) in self.vibration_phase.iter_mut().zip(speed_rad_s) {
            *phase = (*phase + speed * self.dt_s) % std::f64::consts::TAU;
            let amplitude =
                self.settings.vibration_m_s2 * squared(speed / hover_speed_rad_s.max(1.0));
            let (sin, cos) = sin_cos(*phase);
            sum += Vector3::new(cos, sin, 0.5 * sin) * amplitude;
        }
        sum * 0.5
    }

    /// The motion-capture sample that arrives in this step, if one does. The caller calls this once a step. The estimator believes that a
    /// sample has the smallest latency; a sample that overtakes older ones makes them worthless.
    pub(super) fn mocap(&mut self, state: &KinematicState) -> Option<Mocap> {
        let s = self.settings;
        self.step += 1;
        self.mocap_phase += s.mocap_hz * self.dt_s;
        if self.mocap_phase >= 1.0 {
            self.mocap_phase -= 1.0;
            let age_steps = (s.mocap_latency_s / self.dt_s).round() as usize;
            let sample = self.sample_mocap(state, age_steps);
            let late = lateness(&s.mocap_link, self.dt_s, &mut self.rng);
            if let (Some(late), false) = (late, self.failures.mocap_lost) {
                let due = self.step + age_steps as u64 + late;
                while self.under_way.back().is_some_and(|(older, _)| *older >= due) {
                    self.under_way.pop_back();
                }
                self.under_way.push_back((due, sample));
            }
        }
        match self.under_way.front() {
            Some((due, _)) if *due <= self.step => {
                self.under_way.pop_front().map(|(_, sample)| sample)
            }
            _ => None,
        }
    }

    fn sample_mocap(&mut self, state: &KinematicState, age_steps: usize) -> Mocap {
        let s = self.settings;
        let mut noise = |std: f64| Vector3::from_fn(|_, _| std * normal(&mut self.rng));
        let tilt = nalgebra::Rotation3::new(noise(s.mocap_noise_rad));
        let position = state.position + noise(s.mocap_noise_m) + self.failures.mocap_offset;
        let payload = state.payload.map(|p| PayloadReading {
            position_in_world: p.position_in_world + self.payload_offset + noise(s.mocap_noise_m),
            yaw_rad: p.yaw_rad,
        });
        Mocap { position, rotation: state.rotation * tilt.matrix(), payload, age_steps }
    }

    /// Quantised joint angles, rad; quantised rates, rad/s, which stay the same between two readings; and whether the rates are new.
    pub(super) fn encoders(
        &mut self,
        state: &KinematicState,
    ) -> (Vector2<f64>, Vector2<f64>, bool) {
        let s = self.settings;
        let angle_step = std::f64::consts::TAU / s.encoder_counts;
        self.encoder_phase += s.joint_velocity_hz * self.dt_s;
        let due = self.encoder_phase >= 1.0;
        if due {
            self.encoder_phase -= 1.0;
        }
        if let (Some(joint), true) = (self.joint, self.failures.encoders_dead) {
            return (joint, self.joint_dot, false);
        }
        if due {
            self.joint_dot = state.joint_dot.map(|v| quantise(v, s.joint_velocity_step_rad_s));
        }
        let joint = state.joint.map(|q| quantise(q, angle_step));
        self.joint = Some(joint);
        (joint, self.joint_dot, due)
    }
}

/// The multiple of `step` nearest to `x`; `x` itself if the step is zero, because an ideal sensor resolves everything.
fn quantise(x: f64, step: f64) -> f64 {
    let steps = (x / step).round();
    if steps.is_finite() { steps * step } else { x }
}

fn normal(rng: &mut Pcg64) -> f64 {
    StandardNormal.sample(rng)
}

#[cfg(test)]
mod tests {
    use super::quantise;

    #[test]
    fn a_reading_is_a_multiple_of_the_step_and_exact_without_one() {
        assert_eq!(quantise(0.26, 0.1).to_bits(), (0.1 * 3.0_f64).to_bits());
        for x in [0.0, -1.3, f64::MIN_POSITIVE] {
            assert_eq!(quantise(x, 0.0).to_bits(), x.to_bits());
            // So small a step that their ratio overflows.
            assert_eq!(quantise(x, f64::MIN_POSITIVE / 4.0).to_bits(), x.to_bits());
        }
    }
}
