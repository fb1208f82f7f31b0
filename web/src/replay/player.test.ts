import { describe, expect, it } from "vitest";
import type { Telemetry } from "../link/decode";
import { split } from "./flight";
import { frameAt, Player } from "./player";

const NONE = new Float32Array();
const frames = Array.from({ length: 100 }, (_, k): Telemetry => {
  return { schemaId: 1, firstTick: 2 * k, rows: 2, channelCount: 0, gap: 0, reset: false, tSim: 0.02 * (k + 1), tWall: 0, channels: NONE, poses: NONE, reference: NONE, contacts: NONE, spectrum: NONE };
});

function watched(): { player: Player; seen: number[]; cleared: () => number } {
  const seen: number[] = [];
  let cleared = 0;
  const screen = { clear: () => (cleared += 1), update: (frame: Telemetry) => seen.push(frame.tSim) };
  return { player: new Player(frames, () => screen), seen, cleared: () => cleared };
}

describe("Player", () => {
  it("finds the newest frame that is not after a time", () => {
    expect(frameAt(frames, 0.02)).toBe(0);
    expect(frameAt(frames, 0.059)).toBe(1);
    expect(frameAt(frames, 0.06)).toBe(2);
    expect(frameAt(frames, 99)).toBe(99);
    expect(frameAt(frames, -1)).toBe(0);
    expect(frameAt([], 1)).toBe(-1);
  });

  it("shows every frame of a short way and clears before a jump back", () => {
    const { player, seen, cleared } = watched();
    player.show(0.02);
    const before = cleared();
    player.show(0.08);
    expect(seen.slice(-3).map((time) => time.toFixed(2))).toEqual(["0.04", "0.06", "0.08"]);
    expect(cleared()).toBe(before);
    player.show(0.04);
    expect(cleared()).toBe(before + 1);
    expect(seen.at(-1)).toBeCloseTo(0.04);
  });

  it("stops at the end and starts over from there", () => {
    const { player } = watched();
    expect(player.toggle(1)).toBe(1);
    player.speed = 4;
    expect(player.advance(1, 0.1)).toBeCloseTo(1.4);
    expect(player.advance(1.9, 1)).toBe(player.endS);
    expect(player.playing).toBe(false);
    expect(player.toggle(player.endS)).toBe(player.startS);
  });
});

describe("split", () => {
  it("refuses a page whose flight is cut off", () => {
    const bytes = new ArrayBuffer(8);
    new DataView(bytes).setUint32(0, 100, true);
    expect(() => split(bytes)).toThrow("cut off at byte 8");
  });
});
