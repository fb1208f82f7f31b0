#!/usr/bin/env python3
"""How well the mirror foresees real flights: `real_flights.py TWIN FILE...` runs `TWIN mirror FILE --headless --json` on each file.

Prints one line for each flight (time in the air, R2 of the thrust, errors in standard deviations: forecast / persistence / mean), and the
number of flights in which the forecast is better than persistence, than the mean, and than both, for each number of ticks ahead.
"""

import json
import pathlib
import subprocess
import sys


def mirrored(program, path):
    """The JSON of one flight; None if it cannot be mirrored."""
    command = [program, "mirror", str(path), "--headless", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        print(f"{path.name:36} {done.stderr.strip()[:120]}")
        return None
    return json.loads(done.stdout)


def main():
    program, paths = sys.argv[1], [pathlib.Path(path) for path in sys.argv[2:]]
    better, flights = {}, 0
    for path in paths:
        found = mirrored(program, path)
        if found is None:
            continue
        shadow = found["shadow"]
        r2 = (found.get("fit") or {}).get("r2")
        scored = [step for step in shadow["prediction"] if step["rmse_z"] is not None]
        errors = " ".join(
            "{rmse_z:.2f}/{persistence_rmse_z:.2f}/{mean_rmse_z:.2f}".format(**step) for step in scored
        )
        worth = "  none" if r2 is None else f"{r2:6.2f}"
        print(f"{path.name:36} {shadow['airborne_ticks'] / 100:5.1f} s R2 {worth}  {errors or 'no residual is known in the air'}")
        flights += bool(scored)
        for step in scored:
            counts = better.setdefault(step["j"], [0, 0, 0])
            beats = (step["better_than_persistence"], step["better_than_mean"])
            for at, holds in enumerate((*beats, all(beats))):
                counts[at] += holds
    for j, counts in better.items():
        print(f"j = {j}: of {flights} flights, {counts[0]} better than persistence, {counts[1]} than the mean, {counts[2]} than both")


main()
