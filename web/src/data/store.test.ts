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
    tSim: 0,
    channels: Float32Array.from(rows.flat()),
    poses: new Float32Array(),
    reference: new Float32Array(7),
    contacts: new Float32Array(),
    ...extra,
  };
}

function store(): Store {
  const s = new Store();
  s.accept(hello);
  return s;
}

describe("Store", () => {
  it("keeps rows in order, knows the newest value and the resets", () => {
    const s = store();
    s.ingest(frame(0, [[1, 0], [2, 1]]));
    s.ingest(frame(2, [[3, 0]]));
    expect([...(s.column("error.x") ?? [])]).toEqual([1, 2, 3]);
    expect(s.latest("error.x")).toBe(3);
    expect(s.resets).toEqual([1]);
    expect(s.timeOf(s.lastTick)).toBeCloseTo(0.03, 12);
    expect(s.latest("nothing")).toBeNaN();
  });

  it("breaks the line where ticks are missing", () => {
    const s = store();
    s.ingest(frame(0, [[1, 0]]));
    s.ingest(frame(9, [[2, 0]], { gap: 8 }));
    expect([...(s.column("error.x") ?? [])]).toEqual([1, NaN, 2]);
  });

  it("forgets the old flight at a reset flag and when ticks run backward", () => {
    for (const next of [frame(50, [[7, 0]], { reset: true }), frame(0, [[7, 0]])]) {
      const s = store();
      s.ingest(frame(10, [[1, 1]]));
      s.ingest(next);
      expect([...(s.column("error.x") ?? [])]).toEqual([7]);
      expect(s.resets).toEqual([]);
    }
  });

  it("takes no frame of another schema", () => {
    const s = store();
    expect(s.ingest(frame(0, [[1, 0]], { schemaId: 5 }))).toBe(false);
    expect(s.ring.length).toBe(0);
  });
});
