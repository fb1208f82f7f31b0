import { Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { blendPose } from "../data/pose";
import { Glide } from "./glide";

/** Tolerance of a few roundings, because values are stored as f32 with 24 bits of mantissa. */
const F32 = 2e-6;

function pose(position: number[], axis: Vector3, angle: number): number[] {
  const q = new Quaternion().setFromAxisAngle(axis.clone().normalize(), angle);
  return [...position, q.w, q.x, q.y, q.z];
}

describe("blendPose", () => {
  // For a turn about one axis slerp has a closed form: the angle is proportional to the share.
  it.each([0, 0.2, 0.5, 0.9, 1])("turns about a fixed axis in proportion, at %f of the way", (part) => {
    const axis = new Vector3(1, -2, 0.5);
    const [from, to] = [pose([1, 2, 3], axis, 0.3), pose([2, 0, 3], axis, 2.3)].map((values) => Float32Array.from(values));
    const out = new Float32Array(7);
    blendPose(out, from!, to!, 0, part);
    pose([1 + part, 2 - 2 * part, 3], axis, 0.3 + 2 * part).forEach((value, i) => expect(Math.abs(out[i]! - value)).toBeLessThan(F32));
  });

  it("takes the short way whatever the sign of the quaternion", () => {
    const axis = new Vector3(0, 0, 1);
    const from = Float32Array.from(pose([0, 0, 0], axis, 0.1));
    const to = Float32Array.from(pose([0, 0, 0], axis, 0.5).map((value, i) => (i >= 3 ? -value : value)));
    const out = new Float32Array(7);
    blendPose(out, from, to, 0, 0.5);
    const wanted = new Quaternion().setFromAxisAngle(axis, 0.3);
    const got = new Quaternion(out[4], out[5], out[6], out[3]);
    expect(got.angleTo(wanted)).toBeLessThan(1e-3);
  });
});

function arrive(glide: Glide, now: number, values: number[], exact = false): void {
  glide.target.set(values);
  glide.arrived(now, exact);
}

const level = (x: number): number[] => [x, 0, 0, 1, 0, 0, 0];

describe("Glide", () => {
  it("shows the first frame, and a frame that is to be exact, as they came", () => {
    const glide = new Glide(1, 1);
    arrive(glide, 0, [...level(1), 5]);
    expect([...glide.shown]).toEqual([...level(1), 5]);
    arrive(glide, 100, [...level(2), 6], true);
    expect([...glide.shown]).toEqual([...level(2), 6]);
    expect(glide.sample(101)).toBe(false);
  });

  it("moves at every drawing between frames at 10 Hz, never past the newest, and never backwards", () => {
    const glide = new Glide(1, 1);
    const steps: number[] = [];
    let shown = -Infinity;
    for (let now = 0; now <= 3000; now += 1000 / 60) {
      const frame = Math.floor(now / 100);
      if (frame !== Math.floor((now - 1000 / 60) / 100)) arrive(glide, now, [...level(frame), frame]);
      glide.sample(now);
      expect(glide.shown[0]!).toBeLessThanOrEqual(frame);
      if (now > 1000) steps.push(glide.shown[0]! - shown);
      shown = glide.shown[0]!;
    }
    // There are six drawings per frame, so each moves by a sixth, up to the unevenness of the times of drawing.
    expect(Math.min(...steps)).toBeGreaterThan(0.05);
    expect(Math.max(...steps)).toBeLessThan(0.4);
  });

  it("lags by less than 20 ms at 100 Hz", () => {
    const glide = new Glide(1, 0);
    let arrivedAt = -10;
    for (let now = 0; now <= 2000; now += 1000 / 60) {
      while (arrivedAt + 10 <= now) {
        arrivedAt += 10;
        arrive(glide, arrivedAt, level(arrivedAt));
      }
      glide.sample(now);
      if (now > 500) expect(arrivedAt - glide.shown[0]!).toBeLessThan(20);
    }
  });

  it("reaches the newest frame exactly when no more come", () => {
    const glide = new Glide(1, 0);
    arrive(glide, 0, level(0));
    glide.sample(90);
    arrive(glide, 100, level(0.1));
    glide.sample(100 + glide.durationMs + 1);
    expect([...glide.shown]).toEqual([...Float32Array.from(level(0.1))]);
    expect(glide.sample(1000)).toBe(false);
  });

  it("passes the unknown on at once and takes a value up again at once", () => {
    const glide = new Glide(1, 1);
    arrive(glide, 0, [...level(0), 1]);
    arrive(glide, 50, [NaN, NaN, NaN, NaN, NaN, NaN, NaN, NaN]);
    glide.sample(51);
    expect([...glide.shown].every(Number.isNaN)).toBe(true);
    arrive(glide, 100, [...level(3), 4]);
    glide.sample(101);
    expect(glide.shown[0]).toBe(3);
    expect(glide.shown[7]).toBe(4);
  });
});
