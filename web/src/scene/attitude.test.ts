import { Euler, Quaternion } from "three";
import { describe, expect, it } from "vitest";
import { rollPitchYawDeg } from "./attitude";

describe("rollPitchYawDeg", () => {
  // The order "ZYX" of three.js turns by yaw, then pitch, then roll, which is the project's convention.
  it.each([[10, -20, 30], [-170, 5, 179], [0, 79, -90], [0, 0, 0]])("agrees with three's ZYX angles for %i %i %i", (roll, pitch, yaw) => {
    const rad = (deg: number): number => (deg * Math.PI) / 180;
    const q = new Quaternion().setFromEuler(new Euler(rad(roll), rad(pitch), rad(yaw), "ZYX"));
    const got = rollPitchYawDeg([q.w, q.x, q.y, q.z]);
    [roll, pitch, yaw].forEach((value, i) => expect(got[i]).toBeCloseTo(value, 6));
  });
});
