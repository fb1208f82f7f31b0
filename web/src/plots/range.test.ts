import { describe, expect, it } from "vitest";
import { boundsOf, decadeRange, formatValue, linearRange, niceStep } from "./range";

describe("linearRange", () => {
  it("always contains the values and never loses the previous range without need", () => {
    let range = linearRange(null, [-1, 1], 0.1);
    expect(range[0]).toBeLessThanOrEqual(-1);
    expect(range[1]).toBeGreaterThanOrEqual(1);
    const kept = linearRange(range, [-0.6, 0.7], 0.1);
    expect(kept).toBe(range);
    range = linearRange(range, [-1, 8.3], 0.1);
    expect(range[1]).toBeGreaterThanOrEqual(8.3);
  });

  it("shrinks when the values need less than a third", () => {
    const wide = linearRange(null, [-100, 100], 0.1);
    const narrow = linearRange(wide, [-1, 1], 0.1);
    expect(narrow[1]).toBeLessThan(5);
  });

  it("does not blow up noise below the smallest span", () => {
    const [low, high] = linearRange(null, [0.00001, 0.00002], 0.5);
    expect(high - low).toBeGreaterThanOrEqual(0.5);
  });

  it("keeps the last range when nothing is known", () => {
    expect(linearRange([2, 3], null, 1)).toEqual([2, 3]);
  });
});

describe("decadeRange", () => {
  it("covers whole decades", () => {
    expect(decadeRange(null, [3, 250])).toEqual([1, 1000]);
    expect(decadeRange(null, [10, 10])).toEqual([10, 100]);
  });

  it("grows at once, and shrinks only when two decades are to spare", () => {
    expect(decadeRange([1, 10], [0.9, 5])).toEqual([0.1, 10]);
    expect(decadeRange([0.1, 10], [1.1, 5])).toEqual([0.1, 10]);
    expect(decadeRange([0.1, 100], [1.1, 5])).toEqual([1, 10]);
  });
});

describe("numbers", () => {
  it("rounds steps up to 1, 2, 5", () => {
    expect([0.011, 0.3, 1, 2.5, 7].map(niceStep)).toEqual([0.02, 0.5, 1, 5, 10]);
  });

  it("prints at most seven characters and says when nothing is known", () => {
    for (const value of [0, -0.123456, 12.3456, -123.456, 99999, -1e7, 3e-5]) expect(formatValue(value).length).toBeLessThanOrEqual(7);
    expect(formatValue(NaN)).toBe("—");
    expect(formatValue(-0.5)).toBe("−0.500");
  });

  it("leaves out what is missing, and what a logarithm cannot show", () => {
    expect(boundsOf([[1, null, -4], [undefined, 9]], false)).toEqual([-4, 9]);
    expect(boundsOf([[0, -4, 2]], true)).toEqual([2, 2]);
    expect(boundsOf([[null]], false)).toBeNull();
  });
});
