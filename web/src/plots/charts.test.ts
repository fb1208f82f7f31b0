import { describe, expect, it } from "vitest";
import { addOwn, MOST_OWN, parse, standard } from "./arrangement";
import { clockSplits, clockText } from "./clock";
import { clusters } from "./clusters";
import { unknownSpans } from "./marks";
import { matching } from "./search";
import { chartSpecs, ownSpec } from "./spec";
import type { ChannelInfo } from "../protocol";

const channel = (name: string, label: string, group: string, unit: string, row: string | null = null): ChannelInfo =>
  ({ name, label, group, unit, row, limits: null, z_scale: null, weight: null });

const CHANNELS = [
  channel("residual.phi", "measured r phi", "residual", "N m", "phi"),
  channel("residual.z", "measured r z", "residual", "N", "z"),
  channel("covariance_trace", "tr Σ", "adapter", ""),
  channel("rotor.0", "rotor 1", "actuators", "N"),
  channel("force.payload.z", "payload z", "forces", "N", "z"),
  channel("force.thrust.z", "thrust z", "forces", "N", "z"),
  channel("joint_torque.1", "joint 1 torque", "actuators", "N m"),
];

describe("matching", () => {
  const names = (query: string): string[] => matching(CHANNELS, query).map(({ name }) => name);

  it("looks at name, label, group, unit and symbol, whatever the case", () => {
    expect(names("")).toHaveLength(CHANNELS.length);
    expect(names("RESID")).toEqual(["residual.phi", "residual.z"]);
    expect(names("φ")).toEqual(["residual.phi"]);
    expect(names("tr σ")).toEqual(["covariance_trace"]);
    expect(names("actuators torque")).toEqual(["joint_torque.1"]);
  });

  it("asks for every word", () => {
    expect(names("residual phi")).toEqual(["residual.phi"]);
    expect(names("residual rotor")).toEqual([]);
  });
});

describe("chartSpecs", () => {
  it("shows what the flight has and nothing else, the residual first", () => {
    const specs = chartSpecs("z", CHANNELS);
    expect(specs.map(({ key }) => key)).toEqual(["residual", "covariance", "spectrum", "forces", "rotors", "joints"]);
    expect(specs[0]?.series.map(({ channel }) => channel)).toEqual(["residual.z"]);
  });

  it("beside a recording shows how far twin and vehicle part, and no term of a controller", () => {
    const channels = ["position_error_m", "robust_gain", "gain_norm"].map((name) => channel(name, name, "", ""));
    const titles = (mirrored: boolean): string[] => chartSpecs("z", channels, mirrored).map(({ title }) => title);
    expect(titles(false)).toEqual(["Tracking error", "Robust term", "Spectrum of Σ", "Adapter norms"]);
    expect(titles(true)).toEqual(["Divergence from the twin", "Spectrum of Σ", "Adapter norms"]);
  });

  it("gives the lines of an own chart different colours or patterns", () => {
    const own = ownSpec({ key: "own-1", title: "t", channels: ["rotor.0", "nothing", "residual.phi", "residual.z"] }, CHANNELS);
    expect(own.series.map(({ label }) => label)).toEqual(["rotor 1", "measured r φ", "measured r z"]);
    expect(new Set(own.series.map(({ color, dash }) => JSON.stringify([color, dash]))).size).toBe(3);
  });
});

describe("arrangement", () => {
  it("comes back from what was stored, and falls back piece by piece on what cannot be used", () => {
    const chosen = { ...standard(), hidden: ["robust"], zscore: true, windowS: 60, own: [{ key: "own-1", title: "mine", channels: ["rotor.0"] }] };
    expect(parse(JSON.stringify(chosen))).toEqual(chosen);
    for (const text of [null, "", "{", "7", "[]"]) expect(parse(text)).toEqual(standard());
    expect(parse(JSON.stringify({ hidden: [3, "a"], windowS: 7, own: [{ key: 1 }, null, { key: "k", title: "t" }] }))).toEqual({
      ...standard(),
      hidden: ["a"],
      own: [{ key: "k", title: "t", channels: [] }],
    });
  });

  it("gives every own chart a key of its own, up to a number", () => {
    const arrangement = standard();
    const keys = Array.from({ length: MOST_OWN }, () => addOwn(arrangement)?.key);
    expect(new Set(keys).size).toBe(MOST_OWN);
    expect(addOwn(arrangement)).toBeNull();
    arrangement.own.splice(2, 1);
    expect(addOwn(arrangement)?.key).toBe("own-3");
  });
});

describe("clusters", () => {
  const mark = (time: number, kind: string) => ({ tick: time, time, kind, text: `${kind} at ${time}` });

  it("joins marks that would lie on top of one another and shows the weightiest", () => {
    const found = clusters([mark(0, "phase"), mark(5, "fault"), mark(9, "gain"), mark(20, "phase")], (time) => 2 * time, 14);
    expect(found.map(({ head, x, marks }) => [head.kind, x, marks.length])).toEqual([["fault", 10, 2], ["gain", 18, 1], ["phase", 40, 1]]);
  });

  it("loses no mark", () => {
    const marks = Array.from({ length: 100 }, (_, k) => mark(k * k, "reset"));
    expect(clusters(marks, (time) => time / 10, 14).flatMap((group) => group.marks)).toEqual(marks);
  });
});

describe("unknownSpans", () => {
  it("runs from the first null to the last; a point that is not there neither ends nor makes one", () => {
    expect(unknownSpans([0, 1, 2, 3, 4, 5], [1, null, undefined, null, 2, null])).toEqual([[1, 3], [5, 5]]);
  });

  it("does not count lost ticks", () => {
    expect(unknownSpans([0, 1, 2, 3, 4], [1, null, null, 2, null], [[0.5, 2.5]])).toEqual([[4, 4]]);
  });
});

describe("clock", () => {
  it("gives round times inside the stretch, far enough apart", () => {
    for (const [from, to] of [[0, 20], [12.34, 12.39], [100.2, 760.9]] as const) {
      const splits = clockSplits([from, to], 400, 64);
      expect(splits.length).toBeGreaterThan(1);
      splits.forEach((split, k) => {
        expect(split).toBeGreaterThanOrEqual(from - 1e-9);
        expect(split).toBeLessThanOrEqual(to + 1e-9);
        if (k > 0) expect(((split - (splits[k - 1] ?? 0)) / (to - from)) * 400).toBeGreaterThanOrEqual(64 - 1e-6);
      });
    }
    expect([12.5, 0.05, 100].map(clockText)).toEqual(["12.5 s", "0.05 s", "100 s"]);
  });
});
