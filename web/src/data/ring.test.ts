import { describe, expect, it } from "vitest";
import { lowerBound, Ring } from "./ring";

describe("Ring", () => {
  it("equals a plain list cut to its newest rows, at every length past two wraps", () => {
    const capacity = 7;
    const ring = new Ring(capacity, 2);
    const list: [number, number, number][] = [];
    for (let tick = 0; tick < 3 * capacity; tick += 1) {
      ring.push(tick, [99, tick * 2, tick * 3], 1);
      list.push([tick, tick * 2, tick * 3]);
      const kept = list.slice(-capacity);
      expect([...ring.stampView()]).toEqual(kept.map((row) => row[0]));
      expect([...ring.columnView(0)]).toEqual(kept.map((row) => row[1]));
      expect([...ring.columnView(1)]).toEqual(kept.map((row) => row[2]));
      expect(ring.lastStamp).toBe(tick);
    }
  });

  it("marks a gap with NaN in every column", () => {
    const ring = new Ring(4, 2);
    ring.push(0, [1, 2], 0);
    ring.pushGap(1);
    ring.push(5, [3, 4], 0);
    expect([...ring.columnView(1)]).toEqual([2, NaN, 4]);
    expect([...ring.stampView()]).toEqual([0, 1, 5]);
  });

  it("is empty after clear", () => {
    const ring = new Ring(4, 1);
    ring.push(3, [1], 0);
    ring.clear();
    expect(ring.length).toBe(0);
    expect(ring.lastStamp).toBeNaN();
    expect(ring.columnView(0).length).toBe(0);
  });
});

describe("lowerBound", () => {
  it("finds the first stamp not before the one asked for", () => {
    const stamps = Float64Array.of(2, 4, 4, 9);
    const naive = (stamp: number) => {
      const found = [...stamps].findIndex((value) => value >= stamp);
      return found < 0 ? stamps.length : found;
    };
    for (let stamp = 0; stamp < 11; stamp += 1) expect(lowerBound(stamps, stamp)).toBe(naive(stamp));
  });
});
