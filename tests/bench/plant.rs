//! Speed of the plant beside its error, for several numbers of substeps and sweeps of Rapier's solver.
//!
//! `cargo bench --bench plant` prints a table, `cargo bench --bench plant -- free held` the rows of two cases, and `-- --json` what
//! `tests/bench/mujoco_bench.py` reads. Every case runs in turns with the others, and the median of the turns counts. Four cases:
//! - `free`: open-loop flight with a swinging arm, without air; the error is the distance to the independent model (Runge-Kutta, 0.1 ms);
//! - `swing`: the arm alone swings from a base that does not move; the error is the largest joint angle's;
//! - `table`: a cube falls 5 mm onto the table; the error is its distance from the place where it must rest;
//! - `held`: the closed gripper holds a cube; the error is its slip in the palm.
#![allow(
    missing_docs,
    dead_code,
    unused_imports,
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a bench measures wall-clock time, and shares the vehicles of the tests of the plant"
)]

#[path = "../plant/oracle.rs"]
mod oracle;
#[path = "../plant/rig.rs"]
mod rig;
#[path = "../plant/trajectory.rs"]
mod trajectory;

use std::time::Instant;

use nalgebra::{Vector2, Vector3};
use oracle::GRAVITY_M_S2;
use rig::{Rig, RigSettings, aerial_manipulator, anchored, any_setpoint, carrying, quiet_settings};
use trajectory::{OpenLoop, built, command, fly, settings, simplified};
use twin_core::source::Source;
use twin_core::tick::{ActuatorCommand, GripperCommand};
use twin_plant::model::Robot;
use twin_plant::{PlantSettings, SimulatedVehicle, Start};

/// Substeps of a step and sweeps of a substep.
const CHOICES: [[usize; 2]; 7] = [[1, 1], [1, 8], [1, 16], [1, 32], [2, 2], [4, 1], [4, 8]];

/// Turns of each case and choice.
const TURNS: usize = 7;

/// Ticks of 10 ms in a turn.
const TICKS: usize = 200;

/// Ticks after which the error is read.
const ERROR_TICKS: [u32; 2] = [100, 1000];

/// Steps of 1 ms in a tick.
const STEPS: f64 = 10.0;

/// Mass of the cube, kg, half its edge, m, and the height of its fall, m.
const CUBE_KG: f64 = 0.3;
const HALF_M: f64 = 0.025;
const FALL_M: f64 = 0.005;

/// Force of each finger, N.
const GRIP_N: f64 = 20.0;

/// Ticks in which the fingers build up their force.
const SETTLE: usize = 20;

/// What a case measures.
struct Case {
    name: &'static str,
    unit: &'static str,
    /// Seconds for [`TICKS`] ticks with a choice.
    time: fn([usize; 2]) -> f64,
    /// Errors after [`ERROR_TICKS`] with a choice.
    errors: fn([usize; 2]) -> [f64; 2],
}

const CASES: [Case; 4] = [
    Case { name: "free", unit: "mm", time: time_free, errors: errors_free },
    Case { name: "swing", unit: "deg", time: time_swing, errors: errors_swing },
    Case { name: "table", unit: "mm", time: time_table, errors: errors_table },
    Case { name: "held", unit: "mm", time: time_held, errors: errors_held },
];

fn with(mut settings: PlantSettings, [iterations, sweeps]: [usize; 2]) -> PlantSettings {
    (settings.contact.iterations, settings.contact.sweeps) = (iterations, sweeps);
    settings
}

/// A vehicle without the dry friction that the independent model lacks, free or with a base that does not move, and its rotors' command.
fn open_loop(
    choice: [usize; 2],
    free: bool,
) -> (Robot, PlantSettings, Box<dyn Fn(u32) -> ActuatorCommand>) {
    let robot = simplified(aerial_manipulator());
    let mut settings = with(settings(&robot), choice);
    if free {
        return (robot, settings, Box::new(command));
    }
    let robot = anchored(robot);
    settings.vehicle.rotor.max_thrust_n = f64::MAX.sqrt();
    let carried = carrying(robot.total_mass_kg() * GRAVITY_M_S2, settings.vehicle.rotors.len());
    (robot, settings, Box::new(move |_| carried))
}

/// Advances the vehicle by `ticks`.
fn run(vehicle: &mut SimulatedVehicle, command: &dyn Fn(u32) -> ActuatorCommand, ticks: usize) {
    let (setpoint, mut inner) = (any_setpoint(), OpenLoop(0, command));
    for _ in 0..ticks {
        vehicle.advance(&setpoint, &mut inner);
    }
}

fn time_open_loop(choice: [usize; 2], free: bool) -> f64 {
    let (robot, settings, command) = open_loop(choice, free);
    let mut vehicle = built(&robot, &settings);
    let started = Instant::now();
    run(&mut vehicle, &command, TICKS);
    started.elapsed().as_secs_f64()
}

fn time_free(choice: [usize; 2]) -> f64 {
    time_open_loop(choice, true)
}

fn time_swing(choice: [usize; 2]) -> f64 {
    time_open_loop(choice, false)
}

fn errors_free(choice: [usize; 2]) -> [f64; 2] {
    let (robot, settings, command) = open_loop(choice, true);
    ERROR_TICKS.map(|ticks| fly(&robot, ticks, &settings, &command).0.position_m * 1e3)
}

fn errors_swing(choice: [usize; 2]) -> [f64; 2] {
    let (robot, settings, command) = open_loop(choice, false);
    ERROR_TICKS.map(|ticks| fly(&robot, ticks, &settings, &command).0.joint_deg)
}

/// A vehicle whose base does not move, and a cube above the floor.
fn above_floor(choice: [usize; 2]) -> (SimulatedVehicle, ActuatorCommand) {
    let robot = anchored(aerial_manipulator());
    let mut settings = with(quiet_settings(), choice);
    settings.vehicle.rotor.thrust_scale = 1.0;
    settings.vehicle.rotor.max_thrust_n = f64::MAX.sqrt();
    settings.payload.mass_kg = CUBE_KG;
    settings.payload.position_m = [1.0, 0.0, HALF_M + FALL_M];
    let carried = carrying(robot.total_mass_kg() * GRAVITY_M_S2, settings.vehicle.rotors.len());
    let position = Vector3::new(0.0, 0.0, 2.0);
    let start = Start { position, joints: Vector2::zeros(), grasped: None, inner_steps: 1 };
    (SimulatedVehicle::new(robot, &[], settings, &start, 1).unwrap(), carried)
}

fn time_table(choice: [usize; 2]) -> f64 {
    let (mut vehicle, carried) = above_floor(choice);
    let started = Instant::now();
    run(&mut vehicle, &|_| carried, TICKS);
    started.elapsed().as_secs_f64()
}

fn errors_table(choice: [usize; 2]) -> [f64; 2] {
    ERROR_TICKS.map(|ticks| {
        let (mut vehicle, carried) = above_floor(choice);
        run(&mut vehicle, &|_| carried, ticks as usize);
        let rest = Vector3::new(1.0, 0.0, HALF_M);
        (vehicle.truth().unwrap().payload_position - rest).norm() * 1e3
    })
}

fn gripping(choice: [usize; 2]) -> Rig {
    let wanted =
        RigSettings { cube_kg: CUBE_KG, cube_off_centre_m: 0.0, grip_n: GRIP_N, locked_arm: true };
    Rig::with(&wanted, with(quiet_settings(), choice))
}

fn time_held(choice: [usize; 2]) -> f64 {
    let mut rig = gripping(choice);
    let started = Instant::now();
    rig.run(TICKS, GripperCommand::Close);
    started.elapsed().as_secs_f64()
}

fn errors_held(choice: [usize; 2]) -> [f64; 2] {
    let truths = gripping(choice).run(ERROR_TICKS[1] as usize + SETTLE, GripperCommand::Close);
    let start = truths[SETTLE].payload_in_palm;
    ERROR_TICKS
        .map(|ticks| (truths[SETTLE + ticks as usize - 1].payload_in_palm - start).norm() * 1e3)
}

/// Position of the independent model after a second of free flight, m.
fn reference() -> [f64; 3] {
    let (robot, settings, command) = open_loop(CHOICES[0], true);
    fly(&robot, ERROR_TICKS[0], &settings, &command).0.position.into()
}

fn main() {
    let json = std::env::args().any(|argument| argument == "--json");
    if json {
        println!("{{\"reference_m\":{:?}}}", reference());
    } else {
        println!("| case | substeps x sweeps | x real time | error after 1 s | after 10 s |");
        println!("|---|---|---|---|---|");
    }
    let named: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let wanted = |case: &&Case| named.is_empty() || named.iter().any(|name| name == case.name);
    for case in CASES.iter().filter(wanted) {
        let mut seconds = vec![Vec::new(); CHOICES.len()];
        for _ in 0..TURNS {
            for (times, choice) in seconds.iter_mut().zip(CHOICES) {
                times.push((case.time)(choice));
            }
        }
        for (times, choice) in seconds.iter_mut().zip(CHOICES) {
            times.sort_by(f64::total_cmp);
            let per_s = TICKS as f64 * STEPS / times[TURNS / 2];
            let [early, late] = (case.errors)(choice);
            let ([substeps, sweeps], Case { name, unit, .. }) = (choice, case);
            if json {
                println!(
                    "{{\"case\":\"{name}\",\"substeps\":{substeps},\"sweeps\":{sweeps},\"steps_per_s\":{per_s:.0},\
                     \"unit\":\"{unit}\",\"error_1_s\":{early:.6},\"error_10_s\":{late:.6}}}"
                );
            } else {
                println!(
                    "| {name} | {substeps} x {sweeps} | {:.1} x | {early:.4} {unit} | {late:.4} {unit} |",
                    per_s * 1e-3
                );
            }
        }
    }
}
