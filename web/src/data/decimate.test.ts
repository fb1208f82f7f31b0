import { describe, expect, it } from "vitest";
import { bucketTicks, decimate } from "./decimate";

const seconds = (tick: number): number => tick / 100;

function run(values: number[], ticksPerBucket: number, firstTick = 0) {
  const stamps = Float64Array.from(values, (_, i) => firstTick + i);
  return decimate(stamps, [Float32Array.from(values)], 0, values.length, ticksPerBucket, seconds);
}

describe("decimate", () => {
  it("passes every point through when there is a pixel for each", () => {
    const out = run([1, 2, 3], 1);
    expect(out.x).toEqual([0, 0.01, 0.02]);
    expect(out.series[0]).toEqual([1, 2, 3]);
  });

  it("keeps the extremes of a bucket in the order they happened", () => {
    expect(run([0, 9, -5, 1], 4).series[0]).toEqual([9, -5]);
    expect(run([0, -5, 9, 1], 4).series[0]).toEqual([-5, 9]);
  });

  it("never loses a single-sample spike", () => {
    const values = Array.from({ length: 1000 }, () => 0);
    values[637] = 42;
    expect(Math.max(...(run(values, 10).series[0] as number[]))).toBe(42);
  });

  it("breaks the line at a NaN and still draws the rest of the bucket", () => {
    const out = run([1, NaN, 3, 2], 4);
    expect(out.series[0]).toEqual([1, 3, null]);
    expect(out.x.length).toBe(3);
  });

  it("gives nothing but breaks for a bucket that is NaN throughout", () => {
    expect(run([NaN, NaN], 2).series[0]).toEqual([null, null, null]);
  });

  it("lets a second series go on where only the first is missing", () => {
    const stamps = Float64Array.of(0, 1, 2, 3);
    const first = Float32Array.of(1, NaN, 1, 1);
    const second = Float32Array.of(5, 6, 7, 8);
    const out = decimate(stamps, [first, second], 0, 4, 4, seconds);
    expect(out.series[1]).toEqual([5, 8, undefined]);
  });

  it("keeps x ascending, NaN or not", () => {
    for (const size of [1, 2, 3, 5]) {
      const values = Array.from({ length: 60 }, (_, i) => (i % 7 === 0 ? NaN : i));
      const { x } = run(values, size, 13);
      expect(x.every((value, i) => i === 0 || value > (x[i - 1] ?? 0))).toBe(true);
    }
  });

  it("aligns buckets to ticks, so that scrolling by one tick changes only the ends", () => {
    const values = Array.from({ length: 41 }, (_, i) => Math.sin(i));
    const stamps = Float64Array.from(values, (_, i) => i);
    const column = Float32Array.from(values);
    const before = decimate(stamps, [column], 0, 40, 5, seconds);
    const after = decimate(stamps, [column], 1, 41, 5, seconds);
    const inner = (out: typeof before) => out.series[0]?.slice(2, 14);
    expect(inner(after)).toEqual(inner(before));
  });

  it("chooses buckets that fit the width", () => {
    expect(bucketTicks(2000, 400)).toBe(5);
    expect(bucketTicks(100, 400)).toBe(1);
    expect(bucketTicks(401, 400)).toBe(2);
  });
});
