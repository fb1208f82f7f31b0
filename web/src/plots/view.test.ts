import { beforeEach, describe, expect, it } from "vitest";
import { View } from "./view";

let now = 100;
let view: View;
const length = (): number => view.span()[1] - view.span()[0];

beforeEach(() => {
  now = 100;
  view = new View({ now: () => now, oldest: () => 30 });
});

describe("View", () => {
  it("follows the flight, with the newest tick at the right and room for a forecast", () => {
    expect(view.span()).toEqual([80, 100]);
    now = 103;
    expect(view.span()).toEqual([83, 103]);
    view.leadS = 0.5;
    expect(view.span()).toEqual([83.5, 103.5]);
  });

  it("starts at zero and fills from the left in the first seconds", () => {
    now = 4;
    expect(view.span()).toEqual([0, 20]);
  });

  it("holds its stretch while the flight goes on, and comes back live", () => {
    view.hold();
    const held = view.span();
    now = 160;
    expect(view.span()).toEqual(held);
    expect(view.inspecting).toBe(true);
    expect(view.cursor()).toBe(100);
    view.live();
    expect(view.span()).toEqual([140, 160]);
    expect(view.cursor()).toBeNull();
  });

  it("goes back from a zoom to what was there before: live, or held", () => {
    view.zoom(95, 90);
    expect(view.span()).toEqual([90, 95]);
    view.zoom(91, 92);
    expect(view.back()).toBe(true);
    expect(view.inspecting).toBe(false);
    view.hold();
    const held = view.span();
    view.zoom(91, 92);
    now = 200;
    expect(view.back()).toBe(true);
    expect(view.span()).toEqual(held);
    expect(view.back()).toBe(true);
    expect(view.inspecting).toBe(false);
    expect(view.back()).toBe(false);
  });

  it("never zooms to nothing", () => {
    view.zoom(90, 90);
    expect(length()).toBeGreaterThan(0.01);
  });

  it("shows a moment in the middle, as far as there is history on both sides", () => {
    view.show(60);
    expect(view.span()).toEqual([50, 70]);
    expect(view.cursor()).toBe(60);
    view.show(99);
    expect(view.span()).toEqual([80, 100]);
    view.show(31);
    expect(view.span()[0]).toBeGreaterThanOrEqual(28);
    expect(view.span()[0]).toBeLessThanOrEqual(31);
  });

  it("takes the stretch along when the cursor leaves it, and stops at the ends of the history", () => {
    view.moveCursor(70);
    expect(view.cursor()).toBe(70);
    expect(view.span()[0]).toBeLessThan(70);
    view.moveCursor(-5);
    expect(view.cursor()).toBe(30);
    view.moveCursor(1e9);
    expect(view.cursor()).toBe(100);
    expect(view.span()[1]).toBeGreaterThanOrEqual(100);
    expect(length()).toBeCloseTo(20, 9);
  });

  it("reads the time under the pointer off the stretch shown", () => {
    view.pointer = 0.25;
    expect(view.cursor()).toBe(85);
    expect(view.cursor([0, 4])).toBe(1);
  });

  it("keeps the time under the pointer where it is while the wheel zooms", () => {
    view.scale(0.5, 0.25);
    const [from, to] = view.span();
    expect(to - from).toBeCloseTo(10, 9);
    expect(from + 0.25 * (to - from)).toBeCloseTo(85, 9);
  });

  it("puts and takes away marks, and drops the end of a range that lies on the wrong side", () => {
    view.toggleMarker(50, 0.1);
    view.toggleMarker(40, 0.1);
    expect(view.markers).toEqual([40, 50]);
    view.toggleMarker(50.05, 0.1);
    expect(view.markers).toEqual([40]);
    view.setRange("from", 10);
    view.setRange("to", 20);
    expect(view.range).toEqual({ from: 10, to: 20 });
    view.setRange("from", 30);
    expect(view.range).toEqual({ from: 30, to: null });
  });

  it("keeps the operator's marks for another moment of the same recording, not for another flight", () => {
    view.toggleMarker(3, 0.1);
    view.setRange("from", 1);
    view.setRange("to", 2);
    view.clear(true);
    expect([view.markers, view.marked()]).toEqual([[3], { from: 1, to: 2 }]);
    view.clear();
    expect([view.markers, view.marked()]).toEqual([[], null]);
  });

  it("asks for the playhead of a mirrored recording to be moved, and never stands in a past of its own", () => {
    const asked: number[] = [];
    view.remote = (time) => asked.push(time);
    view.show(60);
    view.moveCursor(70);
    view.zoom(80, 90);
    expect(asked).toEqual([60, 70]);
    expect(view.pinned).toBeNull();
    expect(view.span()).toEqual([80, 90]);
  });
});
