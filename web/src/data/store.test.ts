import { describe, expect, it } from "vitest";
import type { Telemetry } from "../link/decode";
import type { Hello } from "../protocol";
import { Store } from "./store";

const hello = {
  schema_id: 4,
  tick_s: 0.01,
  channels: [
    { name: "error.x", label: "e x", group: "tracking", unit: "m", row: "x" },
    { name: "reset", label: "reset", group: "adapter", unit: "", row: null },
  ],
  events: [],
  forks: [],
  state: {},
} as unknown as Hello;

function frame(firstTick: number, rows: number[][], extra: Partial<Telemetry> = {}): Telemetry {
  return {
    schemaId: 4,
    firstTick,
    rows: rows.length,
    channelCount: 2,
    gap: 0,
    reset: false,
    tSim: 0, tWall: 0,
    channels: Float32Array.from(rows.flat()),
    poses: new Float32Array(),
    reference: new Float32Array(7),
    contacts: new Float32Array(),
    spectrum: new Float32Array(),
    ...extra,
  };
}

function store(): Store {
  const s = new Store();
  s.accept(hello);
  return s;
}

const held = (s: Store): number[] => Array.from({ length: s.history.length }, (_, i) => s.at("error.x", s.history.first + i));

describe("Store", () => {
  it("keeps rows in order, knows the newest value and the resets", () => {
    const s = store();
    s.ingest(frame(0, [[1, 0], [2, 1]]));
    s.ingest(frame(2, [[3, 0]]));
    expect(held(s)).toEqual([1, 2, 3]);
    expect(s.shown("error.x")).toBe(3);
    expect(s.resets).toEqual([1]);
    expect(s.timeOf(s.lastTick)).toBeCloseTo(0.03, 12);
    expect(s.shown("nothing")).toBeNaN();
  });

  it("breaks the line where ticks are missing", () => {
    const s = store();
    s.ingest(frame(0, [[1, 0]]));
    s.ingest(frame(9, [[2, 0]], { gap: 8 }));
    expect(held(s)).toEqual([1, ...Array.from({ length: 8 }, () => NaN), 2]);
    expect(s.gaps).toEqual([{ from: 1, to: 8 }]);
    expect([0, 1, 8, 9].map((tick) => s.lost(tick))).toEqual([false, true, true, false]);
  });

  it("forgets the old flight at a reset flag and when ticks run backward", () => {
    for (const next of [frame(50, [[7, 0]], { reset: true }), frame(0, [[7, 0]])]) {
      const s = store();
      s.ingest(frame(10, [[1, 1]]));
      s.ingest(next);
      expect(held(s)).toEqual([7]);
      expect(s.resets).toEqual([]);
      expect(s.gaps).toEqual([]);
    }
  });

  it("finds the tick of a time, and the time of a tick", () => {
    const s = store();
    for (const tick of [0, 1, 99, 65_537]) expect(s.tickAt(s.timeOf(tick))).toBe(tick);
    expect(s.tickAt(0.034)).toBe(2);
  });

  it("takes no frame of another schema", () => {
    const s = store();
    expect(s.ingest(frame(0, [[1, 0]], { schemaId: 5 }))).toBe(false);
    expect(s.history.length).toBe(0);
  });
});

describe("a mirrored recording", () => {
  const mirror = { file: "flight.mcap", live: false };
  const recording = { ...hello, mirror } as unknown as Hello;
  const rows = (from: number, to: number): number[][] => Array.from({ length: to - from }, (_, k) => [from + k, (from + k) % 50 === 7 ? 1 : 0]);
  const jump = (s: Store, to: Hello, from: number, until: number): void => {
    s.clear();
    s.accept(to);
    expect(s.ingest(frame(from, rows(from, until), { reset: true }))).toBe(true);
  };

  it("keeps what was drawn when it goes back, and when it goes forward again", () => {
    const s = new Store();
    jump(s, recording, 0, 200);
    jump(s, recording, 80, 120);
    expect([s.history.first, s.lastTick, s.resets]).toEqual([0, 119, [7, 57, 107]]);
    jump(s, recording, 150, 180);
    expect([s.history.first, s.lastTick, s.gaps]).toEqual([0, 179, []]);
    for (let tick = 0; tick < 180; tick += 1) expect(s.at("error.x", tick)).toBe(tick);
    // The ticks between are unknown, so no row before them is drawn.
    jump(s, recording, 300, 320);
    expect(s.history.first).toBe(300);
  });

  it("is another one when its gains, its description or its file change, or when it is a stream", () => {
    for (const [before, after, forget] of [
      [recording, recording, true],
      [recording, { ...recording, mirror: { ...mirror, file: "other.mcap" } } as Hello, false],
      [{ ...recording, mirror: { ...mirror, live: true } } as Hello, { ...recording, mirror: { ...mirror, live: true } } as Hello, false],
      [hello, hello, false],
    ] as const) {
      const s = new Store();
      jump(s, before, 0, 200);
      if (forget) s.forgetDrawn();
      jump(s, after, 80, 120);
      expect(s.history.first).toBe(80);
    }
  });
});
