import { describe, expect, it } from "vitest";
import { History } from "./history";
import { covers, lowerBound, spansAbove, touching, within } from "./spans";

function historyOf(values: number[]): History {
  const history = new History(2048, 1);
  values.forEach((value, tick) => history.push(tick, [value], 0));
  return history;
}

describe("spansAbove", () => {
  it("finds the stretches, cut to those asked for; NaN is no stretch", () => {
    const history = historyOf([0, 1, 1, NaN, 1, 0, 0, 1]);
    expect(spansAbove(history, 0, 0, 99, 1)).toEqual([{ from: 1, to: 2 }, { from: 4, to: 4 }, { from: 7, to: 7 }]);
    expect(spansAbove(history, 0, 2, 4, 1)).toEqual([{ from: 2, to: 2 }, { from: 4, to: 4 }]);
  });

  it("at a coarse resolution covers all that the exact one does, and at most a stretch more", () => {
    const history = historyOf(Array.from({ length: 2000 }, (_, i) => (i % 500 > 450 ? 1 : 0)));
    const exact = spansAbove(history, 0, 0, 1999, 1);
    const coarse = spansAbove(history, 0, 0, 1999, 512);
    expect(coarse.length).toBe(exact.length);
    exact.forEach(({ from, to }, k) => {
      expect(coarse[k]?.from).toBeLessThanOrEqual(from);
      expect(coarse[k]?.to).toBeGreaterThanOrEqual(to);
      expect((coarse[k]?.to ?? 0) - (coarse[k]?.from ?? 0)).toBeLessThanOrEqual(to - from + 32);
    });
  });
});

describe("spans and ticks", () => {
  it("finds what touches a stretch and what lies in it", () => {
    const spans = [{ from: 2, to: 4 }, { from: 9, to: 9 }];
    expect(touching(spans, 4, 8)).toEqual([{ from: 2, to: 4 }]);
    expect([1, 2, 4, 5, 9].map((tick) => covers(spans, tick))).toEqual([false, true, true, false, true]);
    expect(within([1, 5, 5, 9], 5, 8)).toEqual([5, 5]);
  });

  it("finds the first tick not before the one asked for", () => {
    const ticks = [2, 4, 4, 9];
    for (let tick = 0; tick < 11; tick += 1) {
      const naive = ticks.findIndex((value) => value >= tick);
      expect(lowerBound(ticks, tick)).toBe(naive < 0 ? ticks.length : naive);
    }
  });
});
