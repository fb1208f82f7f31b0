//! Assembles the parts of a flight from the settings of a scenario.

use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::{Vector2, Vector3};

use super::mission::{joints, task};
use super::settings::{ControllerKind, PredictorKind, Settings, StartKind, TaskKind, Units};
use super::{BuildError, Scenario, failures, trained};
use twin_core::control::{
    Adaptive, Allocation, Controller, Excited, Gains, InnerController, L1, L1Settings, LoopDelays,
    Multisine, Pid, Preset, Rotor,
};
use twin_core::flight::Parts;
use twin_core::notation::{Coords, GRAVITY_M_S2};
use twin_core::residual::{
    ArxRls, Bias, Extrapolated, Gravity, GravityModel, Persistence, Predictor, PredictorInfo,
    RandomFeatures, ZeroPredictor, lra,
};
use twin_core::task::ToolKinematics;
use twin_core::tick::{GripperCommand, Setpoint};
use twin_core::tuning::{Tuning, TuningError};
use twin_plant::model::{Arm, Packages, Robot, Statics};
use twin_plant::{SimulatedVehicle, Start};

/// Number of ticks of history for predictors, `T_l`.
const HISTORY_LEN: usize = 120;

/// Reset threshold of the `tuned` preset: 1.5 × the 99.9 % quantile of the mean innovation over a payload-free flight, 0.74 as the
/// mean of seeds 1 to 5 of `twin fly scenarios/free_flight.toml --headless --seed N` (`innovation_mean_q999`).
const TUNED_RESET_THRESHOLD: f64 = 1.1;

/// The same for a trained predictor, whose forecast leaves a thirtieth of that to the adapter: 0.033 as the mean of seeds 1 to 3 with
/// `--set predictor.kind=fdt`.
const TRAINED_RESET_THRESHOLD: f64 = 0.05;

/// Memory of the correction of the horizon in the `tuned` preset, s: in 20 s of flight every coordinate moves.
const TUNED_HORIZON_MEMORY_S: f64 = 20.0;

/// Bias of the adapter in the `tuned` preset, s.
const TUNED_BIAS_S: f64 = 0.5;

/// The loaded model files of vehicle and arena.
pub(super) struct Models {
    pub(super) robot: Robot,
    pub(super) objects: Vec<Robot>,
}

/// Reads every model file of the scenario.
pub(super) fn models(scenario: &Scenario) -> Result<Models, BuildError> {
    let settings = &scenario.settings;
    let folder = scenario.folder();
    let packages = Packages(packages(scenario)?);
    let robot = Robot::load(&folder.join(&settings.vehicle.urdf), &packages)?;
    let load =
        |object: &twin_plant::ArenaObject| Robot::load(&folder.join(&object.urdf), &packages);
    let objects = settings.arena.objects.iter().map(load).collect::<Result<Vec<_>, _>>()?;
    Ok(Models { robot, objects })
}

/// Name and folder of each package that `package://` addresses of the model files use.
pub(super) fn packages(scenario: &Scenario) -> Result<Vec<(String, PathBuf)>, BuildError> {
    let pairs = scenario.settings.vehicle.packages.iter();
    let folder = scenario.folder();
    pairs
        .map(|pair| match pair.split_once('=') {
            Some((name, path)) if !name.is_empty() && !path.is_empty() => {
                Ok((name.to_owned(), folder.join(path)))
            }
            _ => Err(BuildError::Unfit {
                key: "vehicle.packages",
                reason: format!("found {pair:?}, expected \"name=folder\""),
            }),
        })
        .collect()
}

/// The parts of a scenario's flight.
pub(super) fn parts(scenario: &Scenario) -> Result<Parts, BuildError> {
    let settings = &scenario.settings;
    settings.vehicle.check_rotors()?;
    let Models { robot, objects } = models(scenario)?;
    let arm_joints = arm_joints(settings, &robot)?;
    let arm = arm(settings, &robot, &arm_joints)?;
    let start = start(settings, &arm, &robot, &arm_joints)?;
    let tuning = tuning(settings)?;
    let gravity_model = gravity(&robot, &arm_joints);
    let gravity = || Arc::clone(&gravity_model);
    let (predictor, adapter) = learners(scenario, &tuning, &gravity)?;
    let history_len = predictor.history_len().max(HISTORY_LEN);
    let weight_n = robot.total_mass_kg() * GRAVITY_M_S2;
    let setpoint = first_setpoint(&tuning.gains, &start, weight_n);
    let inner = inner_controller(settings, &robot, &arm_joints)?;
    let controller = controller(settings);
    let (mut schedule, triggers) = failures::schedule(settings)?;
    schedule.extend(settings.disturbances.iter().map(|d| (d.at_s, d.disturbance.clone())));
    let task = task(settings, arm);
    let source = SimulatedVehicle::new(robot, &objects, settings.plant(), &start, settings.seed)?;
    Ok(Parts {
        source: Box::new(source),
        predictor,
        adapter,
        controller,
        inner,
        task,
        gravity: gravity_model,
        tuning,
        schedule,
        triggers,
        setpoint,
        delays: delays(settings),
        history_len,
        outer_divisor: u64::from(settings.controller.outer_divisor.max(1)),
    })
}

/// The predictor of a scenario and an adapter for it, as they are at the start of a flight.
fn learners(
    scenario: &Scenario,
    tuning: &Tuning,
    gravity: &dyn Fn() -> GravityModel,
) -> Result<Learners, BuildError> {
    let settings = &scenario.settings;
    let predictor = failures::predictor(settings, predictor(scenario, tuning, gravity)?);
    let scale = match settings.predictor.units {
        Units::ZScore => predictor.info().scale,
        Units::Physical => Coords::repeat(1.0),
    };
    let adapter = lra::Adapter::new(predictor.regime_len(), scale, &tuning.adapter);
    Ok((predictor, adapter))
}

/// [`learners`] of a scenario of which nothing else is assembled.
pub(super) fn learners_of(scenario: &Scenario) -> Result<Learners, BuildError> {
    let robot = models(scenario)?.robot;
    let joints = arm_joints(&scenario.settings, &robot)?;
    let gravity = || gravity(&robot, &joints);
    learners(scenario, &tuning(&scenario.settings)?, &gravity)
}

/// A predictor with its adapter.
type Learners = (Box<dyn Predictor>, lra::Adapter);

/// The gravity of the vehicle without payload.
fn gravity(robot: &Robot, arm_joints: &[usize]) -> GravityModel {
    let statics = Statics::new(robot, arm_joints);
    Arc::new(move |chi: &Coords| statics.gravity(chi))
}

/// The word of a scenario file for a kind.
pub(super) fn word(kind: &impl serde::Serialize) -> String {
    let value = serde_json::to_value(kind).ok();
    value.as_ref().and_then(serde_json::Value::as_str).unwrap_or_default().to_owned()
}

fn arm_joints(settings: &Settings, robot: &Robot) -> Result<Vec<usize>, BuildError> {
    let names = &settings.vehicle.arm_joints;
    if names.len() > 2 {
        let reason =
            format!("{} joints given, at most two have rows; leave the others out", names.len());
        return Err(BuildError::Unfit { key: "vehicle.arm_joints", reason });
    }
    if names.len() == 2 && names[0] == names[1] {
        let reason = format!("{:?} is named twice; name each joint once", names[0]);
        return Err(BuildError::Unfit { key: "vehicle.arm_joints", reason });
    }
    names
        .iter()
        .map(|name| {
            robot.joint(name).ok_or_else(|| BuildError::Unfit {
                key: "vehicle.arm_joints",
                reason: format!(
                    "the URDF has no joint {name:?}; it has {}",
                    robot.joints.iter().map(|j| j.name.as_str()).collect::<Vec<_>>().join(", ")
                ),
            })
        })
        .collect()
}

fn arm(settings: &Settings, robot: &Robot, joints: &[usize]) -> Result<Arm, BuildError> {
    let tool = if settings.vehicle.tool_link.is_empty() {
        robot.root
    } else {
        robot.link(&settings.vehicle.tool_link).ok_or_else(|| BuildError::Unfit {
            key: "vehicle.tool_link",
            reason: format!(
                "the URDF has no link {:?}; it has {}",
                settings.vehicle.tool_link,
                robot.links.iter().map(|l| l.name.as_str()).collect::<Vec<_>>().join(", ")
            ),
        })?
    };
    Ok(Arm::new(robot, joints, tool))
}

fn start(
    settings: &Settings,
    arm: &Arm,
    robot: &Robot,
    arm_joints: &[usize],
) -> Result<Start, BuildError> {
    let steps = 1000.0 / settings.controller.inner_hz;
    if steps.fract() != 0.0 || steps < 1.0 {
        let reason =
            format!("{} Hz does not divide the plant's 1000 Hz", settings.controller.inner_hz);
        return Err(BuildError::Unfit { key: "controller.inner_hz", reason });
    }
    let position = Vector3::from(settings.task.start_position_m);
    let (key, angles_rad) = match settings.task.kind {
        TaskKind::PickPlace | TaskKind::Path | TaskKind::Excitation => {
            ("task.transit_joints_rad", settings.task.transit_joints_rad)
        }
        TaskKind::Hover => ("task.grasp_joints_rad", settings.task.grasp_joints_rad),
    };
    let joints = joints(settings, angles_rad);
    within_limits(key, &joints, robot, arm_joints)?;
    let grasped = (settings.task.start == StartKind::Grasped)
        .then(|| position + arm.tool_in_body(&joints).translation.vector);
    Ok(Start { position, joints, grasped, inner_steps: steps as u64 })
}

/// Refuses a start with a joint beyond its limits: the solver would throw the arm back with any force.
fn within_limits(
    key: &'static str,
    angles_rad: &Vector2<f64>,
    robot: &Robot,
    arm_joints: &[usize],
) -> Result<(), BuildError> {
    for (angle, joint) in
        angles_rad.iter().zip(arm_joints.iter().map(|joint| &robot.joints[*joint]))
    {
        if !(joint.lower..=joint.upper).contains(angle) {
            let reason = format!(
                "the flight would begin with {} at {angle} rad, but the URDF limits it to {}..={} rad",
                joint.name, joint.lower, joint.upper
            );
            return Err(BuildError::Unfit { key, reason });
        }
    }
    Ok(())
}

/// Properties of the predictor that are known before its first forecast; only trained weights differ from the default.
pub(super) fn predictor_info(scenario: &Scenario) -> Result<PredictorInfo, BuildError> {
    match scenario.settings.predictor.kind {
        PredictorKind::Fdt | PredictorKind::Trained => {
            Ok(trained::predictor(scenario, &tuning(&scenario.settings)?)?.info())
        }
        _ => Ok(PredictorInfo::default()),
    }
}

fn predictor(
    scenario: &Scenario,
    tuning: &Tuning,
    gravity: &dyn Fn() -> GravityModel,
) -> Result<Box<dyn Predictor>, BuildError> {
    let settings = &scenario.settings;
    Ok(match settings.predictor.kind {
        PredictorKind::Fdt | PredictorKind::Trained => trained::predictor(scenario, tuning)?,
        PredictorKind::None => Box::new(ZeroPredictor),
        PredictorKind::Gravity => Box::new(Gravity::new(gravity())),
        // An oracle rehearses with persistence.
        PredictorKind::Persistence | PredictorKind::Oracle => Box::new(Persistence),
        PredictorKind::TdcExtrapolated => Box::new(Extrapolated),
        PredictorKind::ArxRls => Box::new(ArxRls::default()),
        PredictorKind::Bias => Box::new(Bias::new(gravity())),
        PredictorKind::RandomFeatures => Box::new(RandomFeatures::new(
            gravity(),
            settings.predictor.features,
            settings.predictor.seed,
        )),
    })
}

/// The delays of the loop as they are modelled: the true lag of a rotor is not known to the controller.
fn delays(settings: &Settings) -> LoopDelays {
    let vehicle = &settings.vehicle;
    LoopDelays {
        rotors_s: vehicle.rotor.delay_s + vehicle.rotor.modelled_lag_s,
        joints_s: vehicle.joint_delay_s,
    }
}

pub(super) fn controller(settings: &Settings) -> Box<dyn Controller> {
    let law: Box<dyn Controller> = match settings.controller.kind {
        ControllerKind::Adaptive => Box::new(Adaptive::default()),
        ControllerKind::Pid => Box::new(Pid::default()),
        ControllerKind::L1 => Box::new(L1::new(L1Settings {
            pole_per_s: settings.controller.l1.pole_per_s,
            cutoff_rad_s: settings.controller.l1.cutoff_rad_s,
        })),
    };
    let m = &settings.controller.multisine;
    if m.tones == 0 {
        return law;
    }
    let multisine = Multisine::new(m.tones, m.force_hz, m.moment_hz, m.rms, settings.seed);
    Box::new(Excited::new(law, multisine))
}

/// The values of a preset for this vehicle, without the gains of the scenario.
pub(super) fn preset_tuning(settings: &Settings, preset: Preset) -> Tuning {
    let mut adapter = lra::Settings::default();
    match preset {
        Preset::Literal => adapter.trace_cap_per_feature = f64::MAX,
        Preset::Paper => {}
        Preset::Tuned => {
            adapter.bias_s = TUNED_BIAS_S;
            adapter.horizon_memory_s = TUNED_HORIZON_MEMORY_S;
            adapter.reset_threshold = match settings.predictor.kind {
                PredictorKind::Fdt | PredictorKind::Trained => TRAINED_RESET_THRESHOLD,
                _ => TUNED_RESET_THRESHOLD,
            };
        }
    }
    let gains = Gains {
        nominal_inertia: Coords::from(settings.controller.nominal_inertia),
        safe_set: settings.controller.limits,
        ..Gains::preset(preset)
    };
    Tuning { gains, adapter }
}

/// The values in force at the start: the preset with the gains that the scenario overrides.
pub(super) fn tuning(settings: &Settings) -> Result<Tuning, TuningError> {
    let gains = &settings.gains;
    let mut tuning = preset_tuning(settings, gains.preset);
    if let Some(law) = gains.inner_law {
        tuning.gains.inner_law = law;
    }
    let rows = [("slope", gains.slope), ("damping", gains.damping), ("lead", gains.lead)];
    for (stem, values) in rows {
        for (row, value) in
            twin_core::notation::COORDINATE_NAMES.iter().zip(values.iter().flatten())
        {
            tuning.set(&format!("{stem}.{row}"), *value)?;
        }
    }
    for (name, value) in &gains.scalars {
        tuning.set(name, *value)?;
    }
    Ok(tuning)
}

fn inner_controller(
    settings: &Settings,
    robot: &Robot,
    arm_joints: &[usize],
) -> Result<InnerController, BuildError> {
    let rotor = &settings.vehicle.rotor;
    let rotors: Vec<Rotor> = settings
        .vehicle
        .rotors
        .iter()
        .map(|place| Rotor {
            position_in_body: Vector3::from(place.position_m),
            torque_per_thrust_m: -place.spin * rotor.torque_ratio_m,
        })
        .collect();
    if rotor.min_thrust_n >= rotor.max_thrust_n {
        let reason = format!("{} N is not below vehicle.rotor.max_thrust_n", rotor.min_thrust_n);
        return Err(BuildError::Unfit { key: "vehicle.rotor.min_thrust_n", reason });
    }
    let limit = |row: usize| arm_joints.get(row).map_or(0.0, |joint| robot.joints[*joint].effort);
    Ok(InnerController::new(
        Allocation::new(&rotors, rotor.min_thrust_n, rotor.max_thrust_n),
        Vector3::from(settings.controller.attitude_inertia_kg_m2),
        Vector2::new(limit(0), limit(1)),
        settings.controller.limits.tilt_rad,
        1.0 / settings.controller.inner_hz,
    ))
}

fn first_setpoint(gains: &Gains, start: &Start, weight_n: f64) -> Setpoint {
    Setpoint {
        force_in_world_n: Vector3::new(0.0, 0.0, weight_n),
        yaw_des: [0.0; 3],
        joint_des: start.joints,
        joint_des_dot: Vector2::zeros(),
        joint_des_ddot: Vector2::zeros(),
        r_hat: Coords::zeros(),
        sliding_norm: 1.0,
        robust_gain: 0.0,
        rows: gains.rows(),
        gripper: if start.grasped.is_some() { GripperCommand::Close } else { GripperCommand::Open },
    }
}
