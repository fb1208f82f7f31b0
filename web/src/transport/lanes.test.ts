import { describe, expect, it } from "vitest";
import { Store } from "../data/store";
import { View } from "../plots/view";
import type { EventInfo, Hello } from "../protocol";
import { lanesOf, MARK_LANES, stopsOf } from "./lanes";

const TICKS = 400;
const event = (tick: number, kind: string, text = kind): EventInfo => ({ tick, t_s: tick / 100, kind, text });

/** A flight of 4 s at whose tick 200 the innovation is twice the threshold. */
function flown(mirror: unknown = null): { store: Store; view: View } {
  const channels = ["innovation_mean", "reset_threshold", "reset"].map((name) => ({ name, row: null }));
  const events = [event(0, "phase", "hovering"), event(150, "phase", "picking"), event(160, "gain"), event(200, "reset"), event(300, "grasp"), event(310, "surprise")];
  const store = new Store();
  store.accept({ schema_id: 1, tick_s: 0.01, channels, events, forks: [], state: {}, mirror } as unknown as Hello);
  const rows = Array.from({ length: TICKS }, (_, tick) => [tick === 200 ? 1 : 0.1, 0.5, tick === 200 ? 1 : 0]);
  const empty = new Float32Array();
  store.ingest({ schemaId: 1, firstTick: 0, rows: TICKS, channelCount: 3, gap: 0, reset: false, tSim: 4, tWall: 0, channels: Float32Array.from(rows.flat()), poses: empty, reference: empty, contacts: empty, spectrum: empty });
  return { store, view: new View({ now: () => store.timeOf(store.lastTick), oldest: () => 0.01 }) };
}

describe("the lanes of the timeline", () => {
  it("have each phase up to the next, each kind of mark in its lane, and a kind that nobody knows in the last", () => {
    const { store, view } = flown();
    const { phases, marks } = lanesOf(store, view, [0, 4], 400);
    expect(phases.map(({ text }) => text)).toEqual(["hovering", "picking"]);
    expect(phases[0]?.span.map((time) => Math.round(time * 100))).toEqual([1, 151]);
    expect(phases[1]?.span[1]).toBeCloseTo(4);
    const kinds = Object.fromEntries(MARK_LANES.map(({ key }, lane) => [key, marks[lane]?.map(({ kind }) => kind)]));
    expect(kinds).toEqual({ adapter: ["reset"], gains: ["gain"], world: ["grasp", "surprise"] });
  });

  it("show the innovation over its threshold where it is largest, however narrow the timeline is", () => {
    for (const width of [400, 100, 7]) {
      const { store, view } = flown();
      const { ribbon } = lanesOf(store, view, [0, 4], width);
      const most = Math.max(...ribbon.filter((ratio) => !Number.isNaN(ratio)));
      expect(most).toBeCloseTo(2);
      expect(ribbon.indexOf(most)).toBe(Math.floor((201 * width) / 400));
    }
  });

  it("have the phases of a whole recording, also of its part that was not played yet", () => {
    const phases = [event(0, "phase", "on the ground"), event(50, "phase", "in the air"), event(900, "phase", "landed")];
    const { store, view } = flown({ phases, duration_s: 12 });
    const lanes = lanesOf(store, view, [0, 12], 100);
    expect(lanes.phases.map(({ text }) => text)).toEqual(["on the ground", "in the air", "landed"]);
    expect(lanes.phases[2]?.span[1]).toBe(12);
  });

  it("stop at every event once, in the order of time", () => {
    const { store, view } = flown();
    view.toggleMarker(0.5, 0.01);
    expect(stopsOf(store, view).map((time) => Math.round(time * 100))).toEqual([1, 50, 151, 161, 201, 301, 311]);
  });
});
