"""Steps per second and errors of the plant beside those of MuJoCo, from the same URDF, in the same run.

Usage: mujoco_bench.py [ROUNDS]        (needs: mujoco 4.0.0; builds and runs `cargo bench --bench plant`)

Both step by 1 ms, and their rounds alternate. The four cases are those of tests/bench/plant.rs: free flight with a swinging arm, the arm
alone, a cube that falls 5 mm onto the ground, a cube in the closed gripper. A step of the plant has more in it than one of MuJoCo: rotors,
air, sensors and the estimator.

The error of free flight is the largest distance to a fine integration of the same equations, and that of the arm is the largest angle. The
reference of the plant is its independent model; that of MuJoCo is MuJoCo with the Runge-Kutta method and steps of 0.05 ms. Their distance
after 1 s is printed too, because it says whether both fly the same vehicle. The error of the falling cube is its distance from the place
where it must rest; the error of the held cube is its slip. Reports, asserts nothing.
"""

import json
import math
import pathlib
import statistics
import subprocess
import sys
import time
import tomllib

import mujoco
import numpy as np

ROOT = pathlib.Path(__file__).parents[2]
URDF = ROOT / "urdf/aerial_manipulator.urdf"
DEFAULTS = tomllib.loads((ROOT / "scenarios/defaults.toml").read_text())
STEP_S = 1e-3
FINE_PARTS = 20
TIMED_STEPS = 5000
ERROR_S = (1.0, 10.0)
SETTLE_S = 0.2
START_RAD = (0.4, 0.8)
HAND_DOWN_RAD = (-0.3508, 1.1397)
CUBE_KG, HALF_M, FALL_M, GRIP_N, FRICTION = 0.3, 0.025, 0.005, 20.0, 0.8
ARM, FINGERS = ("joint1", "joint2"), ("finger_left_joint", "finger_right_joint")
INTEGRATORS = {
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
}


def command(k):
    """Rotor thrusts (N) and joint torques (N m) of step k, as in tests/plant/trajectory.rs."""
    wave = lambda hz, phase: math.sin(2.0 * math.pi * hz * k * STEP_S + phase)
    thrusts = (
        8.20 + 0.10 * wave(0.7, 0.3),
        7.12 + 0.15 * wave(1.1, 1.0),
        7.02 + 0.10 * wave(1.6, 2.0),
        8.12 + 0.15 * wave(0.9, 0.0),
    )
    return thrusts, (0.5 * wave(1.3, 0.0), 0.3 * wave(1.9, 0.5))


def controls(k):
    """Collective thrust, moment about the base's axes and joint torques of step k."""
    thrusts, torques = command(k)
    total, moment = 0.0, np.zeros(3)
    for rotor, thrust in zip(DEFAULTS["vehicle"]["rotors"], thrusts):
        x, y, _ = rotor["position_m"]
        total += thrust
        moment += (y * thrust, -x * thrust, -rotor["spin"] * DEFAULTS["vehicle"]["rotor"]["torque_ratio_m"] * thrust)
    return [total, *moment, *torques]


def turned(body, axis, angle):
    """Turns a body about an axis of its own frame."""
    quat, turn = np.zeros(4), np.zeros(4)
    mujoco.mju_axisAngle2Quat(turn, np.array(axis, float), angle)
    mujoco.mju_mulQuat(quat, body.quat, turn)
    body.quat = quat


def vehicle(free, arm, fingers):
    """The URDF as a MuJoCo specification: base free or fixed, arm moving or with the hand down, fingers moving or closed."""
    spec = mujoco.MjSpec.from_file(str(URDF))
    spec.option.timestep = STEP_S
    spec.compiler.fusestatic = 0
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = 1, 0
    base = spec.body("base_link")
    base.pos = (0.0, 0.0, 2000.0 if free else 2.0)
    if free:
        base.add_freejoint()
    for name, angle in zip(ARM, HAND_DOWN_RAD):
        joint = spec.joint(name)
        if arm:
            joint.armature = DEFAULTS["vehicle"]["joint_armature_kg_m2"]
            joint.frictionloss = 0.0
        else:
            turned(joint.parent, joint.axis, angle)
            spec.delete(joint)
    if not fingers:
        for mimic in list(spec.equalities):
            spec.delete(mimic)
        for name in FINGERS:
            spec.delete(spec.joint(name))
    return spec


def flown(free):
    """Model of the open-loop flight, or of the arm on a fixed base."""
    spec = vehicle(free, arm=True, fingers=False)
    if free:
        spec.body("base_link").add_site(name="rotors")
        for axis in (2, 3, 4, 5):
            gear = np.zeros(6)
            gear[axis] = 1.0
            actuator = spec.add_actuator(name=f"wrench{axis}", trntype=mujoco.mjtTrn.mjTRN_SITE, target="rotors")
            actuator.gear = gear
        for name in ARM:
            spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
    model = spec.compile()
    data = mujoco.MjData(model)
    for name, angle in zip(ARM, START_RAD):
        data.joint(name).qpos = angle
    return model, data


def trajectory(free, integrator, parts):
    """Positions of the base (m) and angles of the arm (rad) every 10 ms; each step is cut into parts."""
    model, data = flown(free)
    model.opt.integrator = integrator
    model.opt.timestep = STEP_S / parts
    path = []
    for k in range(round(ERROR_S[1] / STEP_S)):
        if free:
            data.ctrl[:] = controls(k)
        mujoco.mj_step(model, data, parts)
        if (k + 1) % 10 == 0:
            joints = [data.joint(name).qpos[0] for name in ARM]
            path.append([*(data.qpos[:3] if free else np.zeros(3)), *joints])
    return np.array(path)


def path_errors(free, path, reference):
    """Largest distance (mm) or angle (deg) until each of ERROR_S."""
    away = path - reference
    each = np.linalg.norm(away[:, :3], axis=1) * 1e3 if free else np.degrees(np.abs(away[:, 3:]).max(axis=1))
    return [each[: round(until / 0.01)].max() for until in ERROR_S]


def add_cube(spec, position):
    cube = spec.worldbody.add_body(name="cube", pos=position)
    cube.add_freejoint()
    cube.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=[HALF_M] * 3, mass=CUBE_KG, friction=[FRICTION, 0.005, 1e-4], contype=2, conaffinity=1
    )


def table():
    spec = vehicle(free=False, arm=True, fingers=False)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 1], conaffinity=2, friction=[FRICTION, 0.005, 1e-4])
    add_cube(spec, [1.0, 0.0, HALF_M + FALL_M])
    model = spec.compile()
    return model, mujoco.MjData(model)


def held():
    spec = vehicle(free=False, arm=False, fingers=True)
    for name in ("finger_left", "finger_right"):
        for geom in spec.body(name).geoms:
            geom.friction = [FRICTION, 0.005, 1e-4]
    for name in FINGERS:
        spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
    probe = spec.compile()
    at = mujoco.MjData(probe)
    mujoco.mj_forward(probe, at)
    add_cube(spec, list(at.body("tool").xpos))
    model = spec.compile()
    data = mujoco.MjData(model)
    for name in FINGERS:
        data.joint(name).qpos = HALF_M
        data.actuator(name).ctrl = -GRIP_N
    return model, data


def contact_errors(case, prepare):
    model, data = case()
    prepare(model)
    run = lambda seconds: mujoco.mj_step(model, data, round(seconds / STEP_S))
    if case is table:
        rest, first = np.array([1.0, 0.0, HALF_M]), 0.0
        place = lambda: data.body("cube").xpos - rest
    else:
        palm = lambda: data.body("palm").xmat.reshape(3, 3).T @ (data.body("cube").xpos - data.body("palm").xpos)
        run(SETTLE_S)
        start = palm()
        place = lambda: palm() - start
    errors, passed = [], 0.0
    for until in ERROR_S:
        run(until - passed)
        passed = until
        errors.append(np.linalg.norm(place()) * 1e3)
    return errors


def per_second(build, prepare):
    model, data = build()
    prepare(model)
    mujoco.mj_step(model, data, 100)
    started = time.perf_counter()
    mujoco.mj_step(model, data, TIMED_STEPS)
    return TIMED_STEPS / (time.perf_counter() - started)


def integrate_by(integrator):
    return lambda model: setattr(model.opt, "integrator", integrator)


def elliptic(model):
    """What MuJoCo's documentation advises against slip."""
    model.opt.cone, model.opt.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10.0


def rows():
    """Case, variant, how to build and how to prepare it, its errors and their unit."""
    for case, free, unit in (("free", True, "mm"), ("swing", False, "deg")):
        reference = trajectory(free, mujoco.mjtIntegrator.mjINT_RK4, FINE_PARTS)
        for name, integrator in INTEGRATORS.items():
            errors = path_errors(free, trajectory(free, integrator, 1), reference)
            yield case, name, (lambda free=free: flown(free)), integrate_by(integrator), errors, unit
    for case, build in (("table", table), ("held", held)):
        for name, prepare in (("pyramidal cone", lambda model: None), ("elliptic cone, impratio 10", elliptic)):
            yield case, name, build, prepare, contact_errors(build, prepare), "mm"


def ours():
    """What one round of the plant's own bench says by case and choice, and the position that its independent model reaches after 1 s."""
    shown = subprocess.run(
        ["cargo", "bench", "--quiet", "--bench", "plant", "--", "--json"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout
    lines = [json.loads(line) for line in shown.splitlines() if line.startswith("{")]
    choices = {(line["case"], line["substeps"], line["sweeps"]): line for line in lines if "case" in line}
    return choices, next(line["reference_m"] for line in lines if "reference_m" in line)


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    peers = list(rows())
    plant, speeds, reached = [], [[] for _ in peers], None
    for number in range(rounds):
        print(f"round {number + 1} of {rounds}", file=sys.stderr)
        choices, reached = ours()
        plant.append(choices)
        for (_, _, build, prepare, _, _), seen in zip(peers, speeds):
            seen.append(per_second(build, prepare))
    chosen = (DEFAULTS["contact"]["iterations"], DEFAULTS["contact"]["sweeps"])
    print("| case | simulator | steps/s | ratio to the plant | error after 1 s | after 10 s |\n|---|---|---|---|---|---|")
    for case in ("free", "swing", "table", "held"):
        mine = [shown[(case, *chosen)] for shown in plant]
        base = statistics.median(line["steps_per_s"] for line in mine)
        line = mine[0]
        print(
            f"| {case} | the plant | {base:.0f} | 1 | {line['error_1_s']:.4f} {line['unit']} | {line['error_10_s']:.4f} {line['unit']} |"
        )
        for (name, variant, _, _, errors, unit), seen in zip(peers, speeds):
            if name == case:
                speed = statistics.median(seen)
                shown = " | ".join(f"{error:.4f} {unit}" for error in errors)
                print(f"| {case} | MuJoCo, {variant} | {speed:.0f} | {speed / base:.1f} | {shown} |")
    fine = trajectory(True, INTEGRATORS["RK4"], FINE_PARTS)[round(ERROR_S[0] / 0.01) - 1][:3]
    print(f"\nThe two references of free flight are {np.linalg.norm(fine - np.array(reached)) * 1e3:.6f} mm apart after 1 s.")


if __name__ == "__main__":
    main()
