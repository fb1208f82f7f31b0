import { describe, expect, it } from "vitest";
import { bucketTicks, decimate } from "./decimate";
import { History } from "./history";

const seconds = (tick: number): number => tick / 100;

function historyOf(columns: number[][], firstTick = 0): History {
  const history = new History(4096, columns.length);
  (columns[0] ?? []).forEach((_, i) => history.push(firstTick + i, columns.map((column) => column[i] ?? NaN), 0));
  return history;
}

function run(values: number[], bucket: number, firstTick = 0) {
  return decimate(historyOf([values], firstTick), [{ column: 0, scale: 1 }], firstTick, firstTick + values.length, bucket, seconds);
}

const known = (samples: unknown[]): number[] => samples.filter((sample): sample is number => typeof sample === "number");

describe("decimate", () => {
  it("passes every point through when there is a pixel for each", () => {
    const out = run([1, NaN, 3], 1);
    expect(out.x).toEqual([0, 0.01, 0.02]);
    expect(out.series[0]).toEqual([1, null, 3]);
  });

  it("keeps the extremes of a bucket in the order they happened", () => {
    expect(run([0, 9, -5, 1], 4).series[0]).toEqual([9, -5]);
    expect(run([0, -5, 9, 1], 4).series[0]).toEqual([-5, 9]);
  });

  it("never loses a single-sample spike, at whatever level it reads", () => {
    for (const bucket of [1, 4, 8, 16, 64, 256, 512]) {
      const values = Array.from({ length: 3000 }, () => 0);
      values[1637] = 42;
      expect(Math.max(...known(run(values, bucket, 5).series[0] ?? []))).toBe(42);
    }
  });

  it("draws the same extremes from a level as from every tick", () => {
    const values = Array.from({ length: 3000 }, (_, i) => Math.fround(Math.sin(i / 7) * (i % 31)));
    for (const bucket of [16, 32, 256]) {
      const drawn = run(values, bucket).series[0] ?? [];
      for (let start = 0; start < values.length; start += bucket) {
        const inside = values.slice(start, start + bucket);
        const pair = drawn.slice((2 * start) / bucket, (2 * start) / bucket + 2) as number[];
        expect([...pair].sort((a, b) => a - b)).toEqual([Math.min(...inside), Math.max(...inside)]);
      }
    }
  });

  it("breaks the line at a NaN and still draws the rest of the bucket", () => {
    expect(run([1, NaN, 3, 2], 4).series[0]).toEqual([1, 3, null]);
    expect(run([NaN, NaN, NaN, NaN], 4).series[0]).toEqual([null, null, null]);
  });

  it("lets a second series go on where only the first is missing", () => {
    const history = historyOf([[1, NaN, 1, 1], [5, 6, 7, 8]]);
    const traces = [0, 1].map((column) => ({ column, scale: 1 }));
    expect(decimate(history, traces, 0, 4, 4, seconds).series[1]).toEqual([5, 8, undefined]);
  });

  it("keeps x ascending, NaN or not", () => {
    for (const bucket of [1, 4, 8, 16]) {
      const { x } = run(Array.from({ length: 90 }, (_, i) => (i % 7 === 0 ? NaN : i)), bucket, 13);
      expect(x.every((value, i) => i === 0 || value > (x[i - 1] ?? 0))).toBe(true);
    }
  });

  it("aligns buckets to ticks, so that scrolling by one tick changes only the ends", () => {
    const history = historyOf([Array.from({ length: 65 }, (_, i) => Math.sin(i))]);
    const draw = (from: number) => decimate(history, [{ column: 0, scale: 1 }], from, from + 60, 4, seconds);
    expect(draw(1).x.slice(0, 20)).toEqual(draw(2).x.slice(0, 20));
    expect(draw(1).series[0]?.slice(0, 20)).toEqual(draw(2).series[0]?.slice(0, 20));
  });

  it("chooses buckets of a power of two that fit the width", () => {
    expect([2000, 401, 100, 800, 6000, 60_000].map((ticks) => bucketTicks(ticks, 400))).toEqual([8, 1, 1, 1, 16, 256]);
  });
});
