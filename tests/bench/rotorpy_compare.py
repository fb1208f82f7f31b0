"""Compares the rotors of the plant with RotorPy where both have the same effect.

RotorPy (PyPI rotorpy) describes the rotors of the AscTec Hummingbird by coefficients from flights and wind tunnels: the thrust
k_eta w^2 - k_z w V_z + k_h V_xy^2 and the force -k_d w V_xy in the plane of the rotor. The plant has no such coefficients: it takes radius
and blades. This script gives the plant the Hummingbird's rotor and prints both thrusts and the coefficients that the plant has near hover.

    pip install rotorpy
    python tests/bench/rotorpy_compare.py target/release/twin
"""

import json
import subprocess
import sys

from rotorpy.vehicles.hummingbird_params import quad_params

# Blades of the Hummingbird's 8-inch propellers: two, mean chord 20 mm (measured on the part).
RADIUS_M = 0.1016
BLADE_AREA_M2 = 2 * 0.020 * RADIUS_M
GRAVITY_M_S2 = 9.81


def curve(effects: list, picture: str, x: str) -> list:
    """Points of the plant's curve in the picture of this title and first axis."""
    for effect in effects:
        for found in effect["curves"]:
            if found["picture"] == picture and found["x"].startswith(x) and found["name"] == "twin":
                return found["points"]
    raise SystemExit(f"the plant has no curve {picture!r} over {x!r}")


def at(points: list, x: float) -> float:
    """Value of a curve at x, between its points."""
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        if x0 <= x <= x1:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    raise SystemExit(f"{x} is outside of the curve")


def main() -> None:
    twin = sys.argv[1] if len(sys.argv) > 1 else "twin"
    k_eta, k_m = quad_params["k_eta"], quad_params["k_m"]
    k_z, k_h = quad_params["k_z"], quad_params["k_h"]
    thrust_n = quad_params["mass"] * GRAVITY_M_S2 / quad_params["num_rotors"]
    speed = (thrust_n / k_eta) ** 0.5
    rotor = {
        "radius_m": RADIUS_M,
        "blade_area_m2": BLADE_AREA_M2,
        "thrust_coefficient_n_s2": k_eta,
        "torque_ratio_m": k_m / k_eta,
    }
    sets = [word for key, value in rotor.items() for word in ("--set", f"vehicle.rotor.{key}={value:.9f}")]
    command = [twin, "evaluate", "plant", "--json", "--rotor-thrust", str(thrust_n), *sets]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    effects = json.loads(found.stdout)["effects"]
    climb = curve(effects, "Thrust at constant speed", "climb velocity")
    across = curve(effects, "Thrust at constant speed", "advance ratio")
    print(f"AscTec Hummingbird, one rotor in hover: {thrust_n:.3f} N at {speed:.0f} rad/s")
    print(f"{'motion':24} {'RotorPy, N':>12} {'twin, N':>12}")
    for v in (-0.5, 0.5, 1.0, 2.0):
        print(f"climb {v:+.1f} m/s{'':11} {thrust_n - k_z * speed * v:12.4f} {at(climb, v):12.4f}")
    for v in (1.0, 2.0, 4.0, 6.0):
        print(f"across {v:.1f} m/s{'':11} {thrust_n + k_h * v * v:12.4f} {at(across, v / (speed * RADIUS_M)):12.4f}")
    slope = (at(climb, 0.0) - at(climb, 1.0)) / speed
    lift = at(across, 3.0 / (speed * RADIUS_M)) - thrust_n
    print(f"\n{'coefficient':24} {'RotorPy':>12} {'twin':>12} {'ratio':>8}")
    for name, theirs, ours in (("k_z, 0 to 1 m/s climb", k_z, slope), ("k_h, 0 to 3 m/s across", k_h, lift / 9.0)):
        print(f"{name:24} {theirs:12.3e} {ours:12.3e} {ours / theirs:8.2f}")


if __name__ == "__main__":
    main()
