import { beforeEach, describe, expect, it } from "vitest";
import type { GainInfo } from "../protocol";
import { diff, presetOf } from "./gainDiff";
import { differences, GainSets } from "./gainSets";

class MemoryStore {
  readonly held = new Map<string, string>();
  getItem = (key: string): string | null => this.held.get(key) ?? null;
  setItem = (key: string, value: string): void => void this.held.set(key, value);
}

const set = (a: number, b: number): { name: string; value: number }[] => [{ name: "a", value: a }, { name: "b", value: b }];
let store: MemoryStore;
let sets: GainSets;

beforeEach(() => {
  store = new MemoryStore();
  sets = new GainSets(store);
});

describe("GainSets", () => {
  it("toggles between the two stored sets, A first from anywhere else", () => {
    sets.keep("A", set(1, 2));
    sets.keep("B", set(1, 9));
    expect(sets.next(set(5, 5))).toBe("A");
    expect(sets.next(set(1, 2))).toBe("B");
    expect(sets.next(set(1, 9))).toBe("A");
  });

  it("leads nowhere without a set, or when the only one is in force", () => {
    expect(sets.next(set(1, 2))).toBeNull();
    sets.keep("B", set(1, 2));
    expect(sets.next(set(1, 2))).toBeNull();
    expect(sets.next(set(1, 3))).toBe("B");
  });

  it("survives a reload, and takes what cannot be read for nothing", () => {
    sets.keep("A", set(1, 2));
    expect(new GainSets(store).get("A")).toEqual(set(1, 2));
    for (const text of ["{", "[1]", '{"a":1}', '[{"name":"a"}]']) {
      store.held.set("twin.set.A", text);
      expect(sets.get("A")).toBeNull();
    }
  });

  it("asks only for what differs and exists", () => {
    expect(differences([...set(1, 9), { name: "gone", value: 3 }], set(1, 2))).toEqual([{ name: "b", value: 9 }]);
    expect(differences(set(0.3, 2), set(0.1 + 0.2, 2))).toEqual([]);
  });
});

describe("diff", () => {
  const gains: GainInfo[] = [["a", 3, 1.5], ["b", 2, 2], ["c", 0.1 + 0.2, 0.3]].map(([name, value, preset]) => ({
    name: String(name), label: String(name), group: "g", unit: "N", help: "", min: 0, max: 10, step: 0.1, value: Number(value), preset_value: Number(preset),
  }));

  it("lists reference, now and now minus reference, and only what changed if asked", () => {
    expect(diff(gains, presetOf(gains), true)).toEqual([{ name: "a", label: "a", unit: "N", reference: 1.5, now: 3, delta: 1.5, changed: true }]);
    expect(diff(gains, presetOf(gains), false).map(({ name, delta }) => [name, delta])).toEqual([["a", 1.5], ["b", 0], ["c", 0]]);
  });

  it("leaves out what the reference does not know", () => {
    expect(diff(gains, [{ name: "b", value: 5 }], true).map(({ name, delta }) => [name, delta])).toEqual([["b", -3]]);
  });
});
