import { describe, expect, it } from "vitest";
import { Store } from "../data/store";
import type { Hello } from "../protocol";
import { adapterSentence, marginsOf } from "./story";

const TICKS = 300;

/** Three seconds of flight; `value` gives each channel at each tick. */
function flown(channels: Record<string, (tick: number) => number>): Store {
  const store = new Store();
  const names = Object.keys(channels);
  const infos = names.map((name) => ({ name, row: name.split(".")[1] ?? null, z_scale: 2, limits: name.startsWith("rotor.") ? [0, 10] : null }));
  store.accept({ schema_id: 1, tick_s: 0.01, channels: infos, events: [], forks: [], state: {} } as unknown as Hello);
  const rows = Array.from({ length: TICKS }, (_, tick) => names.map((name) => channels[name]?.(tick) ?? NaN));
  const none = new Float32Array();
  store.ingest({ schemaId: 1, firstTick: 0, rows: TICKS, channelCount: names.length, gap: 0, reset: false, tSim: 3, tWall: 0, channels: Float32Array.from(rows.flat()), poses: none, reference: none, contacts: none, spectrum: none });
  return store;
}

const learning = {
  "residual.z": () => 10, "base.z": () => 5, "adapted.z": () => 9, frozen: () => 0,
  innovation_mean: () => 0.25, reset_threshold: () => 0.5, reset: (tick: number) => (tick === 50 ? 1 : 0),
};

describe("the sentence about the adapter", () => {
  it("says which share of the base error is gone, how near a reset is, and when the last one was", () => {
    // The base is 5 off and the adapted forecast 1, so four fifths are gone. The reset ended tick 50, at 0.51 s.
    expect(adapterSentence(flown({ ...learning, reset: () => 0 }))).toBe("The adapter removes 80 % of the base error; innovation 50 % of δ; no reset.");
    expect(adapterSentence(flown(learning))).toContain("reset 2.5 s ago, learning");
  });

  it("does not call a worse forecast better, and says when nothing is learned or known", () => {
    expect(adapterSentence(flown({ ...learning, "adapted.z": () => 20 }))).toContain("adds 100 % to the base error");
    expect(adapterSentence(flown({ ...learning, frozen: () => 1 }))).toContain("frozen");
    expect(adapterSentence(flown({ ...learning, "residual.z": () => NaN }))).toContain("No residual is known");
  });

  it("is about the moment at the playhead", () => {
    const store = flown(learning);
    store.playhead = 40;
    expect(adapterSentence(store)).toContain("no reset");
  });
});

describe("the margins", () => {
  it("are shares of the limits, and a used one says so", () => {
    const margins = marginsOf(flown({ "rotor.0": () => 4, "rotor.1": () => 7, saturated: () => 1, innovation_mean: () => 0.6, reset_threshold: () => 0.5 }));
    expect(margins).toEqual([
      { name: "rotor thrust", text: "70 % of the most", used: true },
      { name: "innovation", text: "120 % of δ", used: true },
    ]);
  });
});
