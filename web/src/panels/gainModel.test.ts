import { beforeEach, describe, expect, it } from "vitest";
import type { GainInfo } from "../protocol";
import { GainModel, type Requests } from "./gainModel";

const gain = (name: string, value: number): GainInfo => ({
  name, label: name, group: "g", unit: "", help: "", min: 0, max: 10, step: 0.1, value, preset_value: value,
});

let model: GainModel;

/** Answers as a server that accepts every request. */
function obey({ settings }: Requests): void {
  settings.forEach(({ name, value }) => model.echo(name, value, "custom"));
}

function turn(name: string, to: number): void {
  const from = model.get(name)?.value ?? NaN;
  model.commit([{ name, from, to }]);
  model.echo(name, to, "custom");
}

beforeEach(() => {
  model = new GainModel();
  model.load([gain("a", 1), gain("b", 2)], "tuned");
});

describe("GainModel", () => {
  it("believes only the server", () => {
    model.commit([{ name: "a", from: 1, to: 5 }]);
    expect(model.get("a")?.value).toBe(1);
    model.echo("a", 4, "custom");
    expect(model.get("a")?.value).toBe(4);
    expect(model.preset).toBe("custom");
  });

  it("marks what differs from the preset, and only that", () => {
    turn("a", 5);
    expect([model.modified("a"), model.modified("b"), model.modifiedCount()]).toEqual([true, false, 1]);
    turn("a", 1);
    expect(model.modifiedCount()).toBe(0);
  });

  it("walks back and forth through the changes", () => {
    turn("a", 3);
    turn("b", 7);
    turn("a", 4);
    obey(model.undo());
    obey(model.undo());
    expect([model.get("a")?.value, model.get("b")?.value]).toEqual([3, 2]);
    obey(model.redo());
    expect([model.get("a")?.value, model.get("b")?.value]).toEqual([3, 7]);
    obey(model.undo());
    obey(model.undo());
    expect(model.undo().settings).toEqual([]);
    expect([model.get("a")?.value, model.get("b")?.value]).toEqual([1, 2]);
  });

  it("drops the redo branch at a new change", () => {
    turn("a", 3);
    obey(model.undo());
    turn("b", 9);
    expect(model.redo().settings).toEqual([]);
  });

  it("takes a preset back as one action", () => {
    const before = model.snapshot();
    model.echo("a", 8, "paper");
    model.load([gain("a", 8), gain("b", 9)], "paper");
    model.commitSince(before);
    expect(model.modifiedCount()).toBe(0);
    expect(model.undo()).toEqual({ settings: [], preset: "tuned" });
    expect(model.redo()).toEqual({ settings: [], preset: "paper" });
  });

  it("brings values that were no preset back gain by gain", () => {
    turn("a", 3);
    const before = model.snapshot();
    model.load([gain("a", 8), gain("b", 9)], "paper");
    model.commitSince(before);
    expect(model.undo()).toEqual({ settings: [{ name: "a", value: 3 }, { name: "b", value: 2 }], preset: null });
  });

  it("takes an arrow key held down as one action, and two separate changes as two", () => {
    model.commit([{ name: "a", from: 1, to: 2 }], 1000);
    model.commit([{ name: "a", from: 2, to: 3 }], 1100);
    model.commit([{ name: "b", from: 2, to: 3 }], 1200);
    model.commit([{ name: "b", from: 3, to: 4 }], 9000);
    expect([1, 2, 3, 4].map(() => model.undo().settings)).toEqual([
      [{ name: "b", value: 3 }],
      [{ name: "b", value: 2 }],
      [{ name: "a", value: 1 }],
      [],
    ]);
  });

  it("keeps no action that changed nothing", () => {
    model.commit([{ name: "a", from: 1, to: 1 }]);
    expect(model.undo().settings).toEqual([]);
  });
});
