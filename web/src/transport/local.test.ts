import { beforeEach, describe, expect, it } from "vitest";
import { View } from "../plots/view";
import { LocalTransport } from "./local";

let now: number;
const clock = { now: () => now, oldest: () => 10 };

function transport(live: boolean): { view: View; local: LocalTransport } {
  const view = new View(clock);
  return { view, local: new LocalTransport(view, clock, live) };
}

beforeEach(() => {
  now = 100;
});

describe("the playhead of a live flight", () => {
  it("follows the flight until it is moved, then stands while the flight goes on", () => {
    const { local } = transport(true);
    now = 101;
    expect([local.timeS, local.past]).toEqual([101, false]);
    local.step(-0.1);
    now = 120;
    expect(local.timeS).toBeCloseTo(100.9);
    expect(local.past).toBe(true);
  });

  it("plays the past at its speed, and follows the flight again when it has caught up", () => {
    const { local } = transport(true);
    local.seek(90);
    local.toggle();
    local.setSpeed(4);
    local.frame(1);
    expect(local.timeS).toBeCloseTo(94);
    local.frame(2);
    expect([local.past, local.playing, local.timeS]).toEqual([false, false, 100]);
  });

  it("plays a marked range again and again", () => {
    const { view, local } = transport(true);
    view.setRange("from", 50);
    view.setRange("to", 52);
    local.seek(50);
    local.toggleLoop();
    local.toggle();
    local.frame(1.5);
    local.frame(1);
    expect(local.timeS).toBe(50);
    expect(local.playing).toBe(true);
  });

  it("held at the newest moment stands there, and does not play", () => {
    const { local } = transport(true);
    local.toggle();
    now = 101;
    expect([local.past, local.playing, local.timeS]).toEqual([true, false, 100]);
  });

  it("reaches no further back than the history", () => {
    const { local } = transport(true);
    local.seek(-5);
    expect(local.timeS).toBe(10);
  });
});

describe("the playhead of an exported page", () => {
  it("stops at the end, is never in the past, and starts over from the end", () => {
    const { local } = transport(false);
    local.seek(99);
    local.toggle();
    local.frame(5);
    expect([local.playing, local.past, local.timeS]).toEqual([false, false, 100]);
    local.toggle();
    expect([local.playing, local.timeS]).toEqual([true, 10]);
  });

  it("goes on from where a click on a chart puts it while it plays", () => {
    const { view, local } = transport(false);
    local.seek(20);
    local.toggle();
    local.frame(0.5);
    view.moveCursor(60);
    local.frame(0.5);
    expect(local.timeS).toBeCloseTo(60.5);
  });
});
