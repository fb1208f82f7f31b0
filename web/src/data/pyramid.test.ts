import { describe, expect, it } from "vitest";
import { Extremes, LEVEL_TICKS, Pyramid } from "./pyramid";

/** Numbers that repeat, cross zero and are NaN now and then. They depend on `seed` only. */
function numbers(count: number, seed: number): number[] {
  let state = seed;
  return Array.from({ length: count }, () => {
    state = (state * 1103515245 + 12345) % 2147483648;
    return state % 23 === 0 ? NaN : (state % 41) - 20;
  });
}

/** The minimum and maximum of a bucket in their order in time, computed from the definition. */
function naive(values: number[]) {
  const known = values.filter((value) => !Number.isNaN(value));
  const [low, high] = [Math.min(...known), Math.max(...known)];
  const lowFirst = values.indexOf(low) <= values.indexOf(high);
  return known.length === 0 ? [NaN, NaN, true] : [lowFirst ? low : high, lowFirst ? high : low, known.length < values.length];
}

describe("Extremes", () => {
  it("gives minimum and maximum in the order they happened", () => {
    for (let seed = 1; seed < 200; seed += 1) {
      const values = numbers(1 + (seed % 9), seed);
      const extremes = new Extremes();
      values.forEach((value) => extremes.add(value));
      expect([extremes.first, extremes.second, extremes.missing]).toEqual(naive(values));
    }
  });
});

describe("Pyramid", () => {
  it("equals the naive extremes of every whole stretch still held, past several wraps", () => {
    const capacity = 512;
    const pyramid = new Pyramid(capacity);
    const values = numbers(2300, 7);
    const start = 37;
    values.forEach((value, i) => {
      pyramid.add(start + i, value, i === 0);
      if (i % 211 !== 0 && i < values.length - 1) return;
      const newest = start + i;
      LEVEL_TICKS.forEach((ticks, level) => {
        const oldest = Math.max(0, Math.ceil((newest + 1 - capacity) / ticks));
        for (let bucket = oldest; bucket * ticks <= newest; bucket += 1) {
          if (bucket * ticks + ticks <= start) continue;
          const extremes = new Extremes();
          pyramid.read(level, bucket * ticks, extremes);
          const inside = values.slice(Math.max(0, bucket * ticks - start), Math.min(i + 1, (bucket + 1) * ticks - start));
          expect([extremes.first, extremes.second, extremes.missing]).toEqual(naive(inside));
        }
      });
    });
  });
});
