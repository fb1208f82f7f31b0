import { expect, it } from "vitest";
import { Archive } from "./archive";

const row = (tick: number): Float32Array => Float32Array.of(NaN, tick, -tick);

function recalled(archive: Archive, tick: number, most = 100): number[] {
  const found: number[] = [];
  archive.before(tick, most, (known, values, offset) => {
    expect([values[offset], values[offset + 1]]).toEqual([known, -known]);
    found.push(known);
  });
  return found;
}

it("gives the rows that lead up to a tick, and none from before a hole", () => {
  const archive = new Archive(2, 16);
  for (const tick of [0, 1, 2, 4, 5, 6]) archive.put(tick, row(tick), 1);
  expect(recalled(archive, 6)).toEqual([4, 5]);
  expect(recalled(archive, 7, 2)).toEqual([5, 6]);
  expect(recalled(archive, 3)).toEqual([0, 1, 2]);
  expect(recalled(archive, 4)).toEqual([]);
  archive.put(3, row(3), 1);
  expect(recalled(archive, 7)).toEqual([0, 1, 2, 3, 4, 5, 6]);
});

it("forgets what it has no room for, and everything when it is told to", () => {
  const archive = new Archive(2, 4);
  for (let tick = 0; tick < 7; tick += 1) archive.put(tick, row(tick), 1);
  expect(recalled(archive, 7)).toEqual([3, 4, 5, 6]);
  expect(recalled(archive, 5)).toEqual([3, 4]);
  archive.clear();
  expect(recalled(archive, 7)).toEqual([]);
});
