import { describe, expect, it } from "vitest";
import { PoseHistory } from "./history";

const TICK_S = 0.01;
/** Tolerance for f32 positions of a few metres over 0.15 s: 2 * 4e-7 / 0.15, and some margin. */
const SPEED_ROUNDING = 1e-5;
/** Tolerance for angles between f32 quaternions, which are inexact near zero: the root of a rounding, over 0.15 s. */
const TURN_ROUNDING = 5e-3;

/** A uniform motion with uniform yaw, in closed form. */
function pose(t: number): number[] {
  return [1 + 0.4 * t, -2 * t, 0.5 + 0.1 * t, Math.cos(0.35 * t), 0, 0, Math.sin(0.35 * t)];
}

describe("PoseHistory", () => {
  it.each([1, 5, 10])("gives the velocity and the rate of a uniform motion, frames of %i ticks", (ticks) => {
    const history = new PoseHistory();
    for (let i = 0; i < 60; i += 1) {
      const t = i * ticks * TICK_S;
      history.add(t, Float32Array.from([...pose(0), ...pose(t)]));
    }
    const { velocity, turning } = history.motion(1);
    [0.4, -2, 0.1].forEach((value, i) => expect(Math.abs(velocity[i]! - value)).toBeLessThan(SPEED_ROUNDING));
    expect(Math.abs(turning - 0.7)).toBeLessThan(TURN_ROUNDING);
    expect(history.motion(0)).toEqual({ velocity: [0, 0, 0], turning: 0 });
  });

  it("knows nothing from one frame, nor across a jump back in time", () => {
    const history = new PoseHistory();
    history.add(5, Float32Array.from(pose(5)));
    expect(history.motion(0).velocity).toEqual([NaN, NaN, NaN]);
    history.add(0.01, Float32Array.from(pose(0.01)));
    expect(history.motion(0).velocity).toEqual([NaN, NaN, NaN]);
  });
});
