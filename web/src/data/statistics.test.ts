import { describe, expect, it } from "vitest";
import { History } from "./history";
import { statistics } from "./statistics";

function historyOf(values: number[]): History {
  const history = new History(512, 1);
  values.forEach((value, tick) => history.push(tick, [value], 0));
  return history;
}

describe("statistics", () => {
  it("gives minimum, mean, maximum and root mean square of the ticks between, both ends included", () => {
    const found = statistics(historyOf([100, 3, -4, 5, 100]), 0, 1, 3);
    expect(found).toMatchObject({ count: 3, missing: 0, min: -4, max: 5 });
    expect(found.mean).toBeCloseTo(4 / 3, 12);
    expect(found.rms).toBeCloseTo(Math.sqrt(50 / 3), 12);
  });

  it("of a whole number of sine periods is a mean of nothing and a root mean square of amplitude over root two", () => {
    const found = statistics(historyOf(Array.from({ length: 400 }, (_, i) => 2 * Math.sin((2 * Math.PI * i) / 40))), 0, 0, 399);
    // The history stores 32-bit floats, so the tolerance is 1e-6 of the amplitude.
    expect(found.mean).toBeCloseTo(0, 6);
    expect(found.rms).toBeCloseTo(Math.SQRT2, 6);
  });

  it("leaves NaN out, says how many, and knows nothing of what is not held", () => {
    expect(statistics(historyOf([1, NaN, 3]), 0, 0, 9)).toMatchObject({ count: 2, missing: 1, mean: 2 });
    expect(statistics(historyOf([NaN]), 0, 0, 0)).toMatchObject({ count: 0, missing: 1, mean: NaN, rms: NaN });
    expect(statistics(new History(512, 1), 0, 0, 5)).toMatchObject({ count: 0, missing: 0 });
  });
});
