"""Compares RMSE and R² of persistence by horizon, computed with NumPy, with the table of `twin evaluate prediction --json`.

    prediction_check.py TABLE.json TEST.csv TRAINING.csv...

`twin export csv` writes the CSV files of the recording and of the training recordings, in the order of the table. The check uses
the residuals that the program recorded, and none of its arithmetic.
"""

import csv
import json
import sys

import numpy as np

ROWS = ["x", "y", "z", "phi", "theta", "psi", "q1", "q2"]
FROM_S = 2.0  # ticks before this are not scored
TOLERANCE = 1e-9  # two summation orders of 2e5 doubles


def residuals(path):
    with open(path, newline="") as file:
        lines = list(csv.DictReader(file))
    time = np.array([float(line["t_s"]) for line in lines])
    values = np.array([[float(line[f"residual.{row}"]) for row in ROWS] for line in lines])
    return time, values


def main():
    table = json.load(open(sys.argv[1]))
    time, r = residuals(sys.argv[2])
    # The first tick of a flight has no tick before it and is no sample of the statistics.
    training = np.concatenate([residuals(path)[1][1:] for path in sys.argv[3:]])
    mean, std = training.mean(axis=0), training.std(axis=0)
    assert np.allclose(mean, table["statistics"]["output_mean"], rtol=TOLERANCE), "means differ"
    assert np.allclose(std, table["statistics"]["output_std"], rtol=TOLERANCE), "deviations differ"
    row = next(row for row in table["rows"] if row["name"] == "persistence")
    z = (r - mean) / std
    for horizon in row["horizons"]:
        j = horizon["j"]
        # The forecast made at t for t + j is r_{t-1}; at the first tick r_t itself stands for the tick before it.
        target = np.arange(j, len(z))
        target = target[time[target] >= FROM_S]
        error = z[target] - z[np.maximum(target - j - 1, 0)]
        rmse = np.sqrt((error**2).mean())
        spread = ((z[target] - z[target].mean(axis=0)) ** 2).sum(axis=0)
        r2 = (1.0 - (error**2).sum(axis=0) / spread).mean()
        assert len(target) == horizon["samples"], (j, len(target), horizon["samples"])
        assert abs(rmse - horizon["rmse_z"]) < TOLERANCE, (j, rmse, horizon["rmse_z"])
        assert abs(r2 - horizon["r2"]) < TOLERANCE, (j, r2, horizon["r2"])
        print(f"j={j}  RMSE {rmse:.6f}  R2 {r2:.6f}  equal")


main()
