import { describe, expect, it } from "vitest";
import { formatGain, isLogarithmic, positionOf, sliderSteps, valueAt } from "./scale";

const slope = { min: 0, max: 20, step: 0.05 };
const cap = { min: 0.05, max: 1e6, step: 0.05 };

describe("slider scale", () => {
  it("is linear for a gain and logarithmic over decades", () => {
    expect(isLogarithmic(slope)).toBe(false);
    expect(isLogarithmic(cap)).toBe(true);
    expect(positionOf(5, slope)).toBe(0.25);
    expect(positionOf(Math.sqrt(0.05 * 1e6), cap)).toBeCloseTo(0.5, 9);
  });

  it("lands on steps and never outside the range", () => {
    for (let i = 0; i <= 1000; i += 1) {
      const value = valueAt(i / 1000, slope);
      expect(Math.abs(value / 0.05 - Math.round(value / 0.05))).toBeLessThan(1e-9);
      for (const range of [slope, cap]) {
        const v = valueAt(i / 1000, range);
        expect(v >= range.min && v <= range.max).toBe(true);
      }
    }
    expect(valueAt(0, cap)).toBe(0.05);
    expect(valueAt(1, cap)).toBe(1e6);
  });

  it("gives back the position of the value it gave", () => {
    for (const position of [0, 0.1, 0.37, 0.9, 1]) {
      expect(positionOf(valueAt(position, slope), slope)).toBeCloseTo(position, 2);
      expect(positionOf(valueAt(position, cap), cap)).toBeCloseTo(position, 3);
    }
  });

  it("moves by one step of the gain with one step of the slider", () => {
    expect(sliderSteps(slope)).toBe(400);
    expect(valueAt(63 / 400, slope) - valueAt(62 / 400, slope)).toBeCloseTo(0.05, 12);
    expect(sliderSteps(cap)).toBe(2000);
  });

  it("prints no floating-point noise", () => {
    expect(formatGain(0.1 + 0.2)).toBe("0.3");
    expect(formatGain(0.9995)).toBe("0.9995");
  });
});
