import { describe, expect, it } from "vitest";
import { History, HISTORY_TICKS } from "./history";

const CAPACITY = 512;

describe("History", () => {
  it("equals a map from tick to row cut to what it says it holds, past three wraps", () => {
    const history = new History(CAPACITY, 2);
    const map = new Map<number, [number, number]>();
    for (let tick = 100; tick < 100 + 3 * CAPACITY; tick += 1) {
      history.push(tick, [99, tick * 2, tick / 4], 1);
      map.set(tick, [tick * 2, tick / 4]);
      if (tick % 97 !== 0) continue;
      for (let asked = 0; asked <= tick + 3; asked += 13) {
        const held = asked >= history.first && asked <= tick && asked >= 100;
        expect(history.holds(asked)).toBe(held);
        expect([history.at(0, asked), history.at(1, asked)]).toEqual(held ? map.get(asked) : [NaN, NaN]);
      }
      expect(history.length).toBe(history.last - history.first + 1);
    }
    expect(history.length).toBeGreaterThan(CAPACITY - 256);
  });

  it("holds lost ticks as NaN and knows nothing before the first", () => {
    const history = new History(CAPACITY, 1);
    history.push(5, [1], 0);
    history.push(9, [2], 0);
    expect([4, 5, 6, 8, 9, 10].map((tick) => history.at(0, tick))).toEqual([NaN, 1, NaN, NaN, 2, NaN]);
    expect([history.first, history.last, history.length]).toEqual([5, 9, 5]);
  });

  it("starts over when more ticks are lost than it holds, and when it is cleared", () => {
    const history = new History(CAPACITY, 1);
    history.push(0, [1], 0);
    history.push(5000, [2], 0);
    expect([history.first, history.length]).toEqual([5000, 1]);
    history.clear();
    expect(history.length).toBe(0);
    expect(history.holds(5000)).toBe(false);
  });

  it("keeps at least ten minutes of a flight at 100 Hz", () => {
    const history = new History(HISTORY_TICKS, 1);
    for (let tick = 0; tick < HISTORY_TICKS + 300; tick += 1) history.push(tick, [tick], 0);
    expect(history.length).toBeGreaterThanOrEqual(10 * 60 * 100);
  });
});
