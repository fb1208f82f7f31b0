import { expect, test } from "vitest";
import type { TwinInfo } from "../protocol";
import { cells, gateText, verdict } from "./mirrorBar";

const twin: TwinInfo = {
  says: "a stand-in",
  horizon_s: 0.5,
  light: "invalid",
  gate: "better than persistence and than the mean at j = 0; not better than persistence at j = 3",
  gate_passed: false,
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

test("the bar says where the forecast is not better than persistence", () => {
  expect(gateText(twin)).toBe("≈ forecast not better than persistence at j = 3");
  expect(gateText({ ...twin, gate_passed: true })).toContain("✓");
  expect(gateText({ ...twin, gate_passed: null })).toContain("not scored");
});
