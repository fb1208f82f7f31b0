import { describe, expect, it } from "vitest";
import { extentOf, fanOf } from "./fan";
import type { Store } from "../data/store";

/** A store with one tick of 10 ms, number 99, which ends at 1 s. */
function storeOf(values: Record<string, number>): Store {
  const at = (name: string, tick: number): number => (tick === 99 ? (values[name] ?? NaN) : NaN);
  return { withoutWeight: at, at, tickS: 0.01, timeOf: (tick: number) => (tick + 1) * 0.01 } as unknown as Store;
}

const FAN = { "adapted.x": 1, "fan_05.x": 2, "fan_10.x": 4, "fan_25.x": 5 };
const BAND = { "lead_s.x": 0.08, "foreseen.x": 3, "foresight_std_now.x": 1, "foresight_std.x": 3 };

describe("fanOf", () => {
  it("goes from now over the lead to the horizon, at the times that are forecast", () => {
    const fan = fanOf(storeOf({ ...FAN, ...BAND }), "x", 99, 1);
    expect(fan?.points.map(({ time }) => Number(time.toFixed(6)))).toEqual([1, 1.05, 1.08, 1.1, 1.25]);
    expect(fan?.points.map(({ value }) => value)).toEqual([1, 2, 3, 4, 5]);
    expect(fan?.leadS).toBe(0.08);
  });

  it("has a band for 90 % that widens evenly from now to the lead and stays", () => {
    const halves = fanOf(storeOf({ ...FAN, ...BAND }), "x", 99, 1)?.points.map(({ half }) => half ?? NaN) ?? [];
    // 90 % of a normal distribution lie within 1.645 standard deviations; at 5/8 of the lead the deviation is 1 + 5/8 · 2.
    [1, 2.25, 3, 3, 3].forEach((std, k) => expect(halves[k]).toBeCloseTo(1.645 * std, 9));
  });

  it("is multiplied by the scale", () => {
    const fan = fanOf(storeOf({ ...FAN, ...BAND }), "x", 99, 0.5);
    expect(fan?.points[2]).toMatchObject({ value: 1.5, half: expect.closeTo(1.645 * 1.5, 9) });
    expect(extentOf(fan)).toContain(0.5 - 1.645 * 0.5);
  });

  it("has no band without a lead, ends where the forecast ends, and is absent where nothing is known", () => {
    const fan = fanOf(storeOf({ ...FAN, ...BAND, "lead_s.x": 0 }), "x", 99, 1);
    expect(fan?.points.map(({ half }) => half)).toEqual([null, null, null, null]);
    expect(fanOf(storeOf({ "adapted.x": 1 }), "x", 99, 1)?.points).toHaveLength(1);
    expect(fanOf(storeOf(FAN), "x", 98, 1)).toBeNull();
    expect(extentOf(null)).toEqual([]);
  });
});
