import { describe, expect, it } from "vitest";
import type { Telemetry } from "../link/decode";
import { Pictures } from "./pictures";

const CAPACITY = 2048;
const NONE = new Float32Array();

/** A picture of one body at x = `tick` and of a reference at x = −`tick`. */
function frame(tick: number, extra: Partial<Telemetry> = {}): Telemetry {
  const poses = Float32Array.of(tick, 0, 1, 1, 0, 0, 0);
  const reference = Float32Array.of(-tick, 0, 1, 1, 0, 0, 0);
  return { schemaId: 1, firstTick: tick, rows: 1, channelCount: 0, gap: 0, reset: false, tSim: 0, tWall: 0, channels: NONE, poses, reference, contacts: NONE, spectrum: NONE, ...extra };
}

function filled(...ticks: number[]): Pictures {
  const pictures = new Pictures(CAPACITY);
  ticks.forEach((tick) => pictures.put(frame(tick)));
  return pictures;
}

describe("Pictures", () => {
  it("shows the bodies at a tick as telemetry had them, and between two pictures along the line", () => {
    const pictures = filled(10, 14);
    expect([...(pictures.at(14)?.poses ?? [])]).toEqual([14, 0, 1, 1, 0, 0, 0, -14, 0, 1, 1, 0, 0, 0]);
    expect(pictures.at(11)?.poses[0]).toBeCloseTo(11, 5);
    expect(pictures.at(11)?.poses[7]).toBeCloseTo(-11, 5);
  });

  it("makes nothing up before the first picture, after the last one and in a long gap", () => {
    const pictures = filled(100, 200);
    for (const tick of [96, 150, 204]) expect(pictures.at(tick), `tick ${tick}`).toBeNull();
  });

  it("has the picture of a frame for the ticks that came with it", () => {
    const pictures = filled(100, 200);
    expect([98, 202].map((tick) => pictures.at(tick)?.poses[0])).toEqual([100, 200]);
  });

  it("keeps the last ticks of a long flight and forgets the older ones", () => {
    const pictures = new Pictures(CAPACITY);
    for (let tick = 0; tick < 3 * CAPACITY; tick += 1) pictures.put(frame(tick));
    expect(pictures.at(3 * CAPACITY - 1)?.poses[0]).toBe(3 * CAPACITY - 1);
    expect(pictures.at(2 * CAPACITY)?.poses[0]).toBe(2 * CAPACITY);
    expect(pictures.at(2 * CAPACITY - 4)).toBeNull();
  });

  it("keeps contacts and spectrum of their own tick, and a copy, not the memory of the frame", () => {
    const pictures = filled();
    const spectrum = Float32Array.of(3, 1);
    pictures.put(frame(5, { contacts: Float32Array.of(1, 2, 3, 4, 5, 6), spectrum }));
    pictures.put(frame(6));
    spectrum[0] = 9;
    expect([...(pictures.at(5)?.contacts ?? [])]).toEqual([1, 2, 3, 4, 5, 6]);
    expect(pictures.at(6)?.contacts.length).toBe(0);
    expect([...pictures.spectrumAt(5)]).toEqual([3, 1]);
  });

  it("hands over every so many pictures of a stretch, oldest first", () => {
    const seen: number[] = [];
    filled(4, 5, 6, 8, 12, 16).between(5, 16, 4, (tick) => seen.push(tick));
    expect(seen).toEqual([8, 12]);
  });
});
