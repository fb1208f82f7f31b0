import { expect, test } from "vitest";
import type { TwinInfo } from "../protocol";
import { cells, verdict } from "./mirrorBar";

const twin: TwinInfo = {
  says: "a stand-in",
  horizon_s: 0.5,
  light: "invalid",
  axes: [
    { row: "z", twin: 0.3681, with_residual: -0.002, coasting: 0.01 },
    { row: "phi", twin: 0.05, with_residual: 0.04, coasting: 0 },
  ],
};

test("the light is told in words, and what is unknown is no light", () => {
  expect(verdict(twin)).toContain("does not hold");
  expect(verdict({ ...twin, light: null, axes: [] })).toBe("twin: unknown");
});

test("each axis has its misses in its own unit", () => {
  expect(cells(twin)).toEqual([
    ["z", "368 mm", "-2 mm", "10 mm"],
    ["phi", "50 mrad", "40 mrad", "0 mrad"],
  ]);
});
