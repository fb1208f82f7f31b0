import { describe, expect, it } from "vitest";
import type { GainInfo } from "../protocol";
import { fuzzyScore, rank } from "./fuzzy";
import { itemsFor, type Sources } from "./paletteItems";
import { spelled } from "./spelled";

describe("fuzzy match", () => {
  it("wants every letter, in order, whatever the case", () => {
    expect(fuzzyScore("dz", "damping.z")).not.toBeNull();
    expect(fuzzyScore("zd", "damping.z")).toBeNull();
    expect(fuzzyScore("DAMP", "damping.z")).toBe(fuzzyScore("damp", "damping.z"));
    expect(fuzzyScore("", "anything")).toBe(0);
  });

  it("prefers the beginnings of words, then letters in a row, then early ones", () => {
    const better = (query: string, one: string, other: string): boolean => (fuzzyScore(query, one) ?? -1) > (fuzzyScore(query, other) ?? -1);
    expect(better("rs", "restart with a seed", "first")).toBe(true);
    expect(better("pau", "a pause", "a plane up")).toBe(true);
    expect(better("seed", "new seed", "snxexexd")).toBe(true);
    expect(better("z", "zoom", "fuzzy")).toBe(true);
  });

  it("finds the best of several places, not the first", () => {
    // The first p is inside a word; the second begins a word and scores higher.
    expect(fuzzyScore("p", "up pause")).toBeCloseTo((fuzzyScore("p", "xx pause") ?? 0), 9);
  });

  it("drops what fits far worse than the best", () => {
    expect(rank("pause", ["proxyabsolutesome", "pause or continue"], (text) => text)).toEqual(["pause or continue"]);
  });
});

describe("palette", () => {
  const gain = (name: string, label: string): GainInfo => ({ name, label, group: "Λ damping", unit: "", help: "", min: 0, max: 60, step: 0.05, value: 3.5, preset_value: 3.5 });
  const done: string[] = [];
  const sources: Sources = {
    commands: [
      { id: "flight.pause", group: "Flight", description: "pause or continue", keys: ["Space"], action: () => done.push("pause") },
      { id: "locked", group: "Gains", description: "pause nothing", keys: [], action: () => done.push("locked"), when: () => false },
      { id: "page.palette", group: "Page", description: "palette", keys: ["Ctrl+K"], action: () => {}, keyOnly: true },
    ],
    scenarios: [{ name: "hover", title: "Hover" }],
    gains: [gain("damping.z", "Λ z"), gain("damping.q1", "Λ q₁"), gain("forgetting", "λ")],
    setGain: (name, value) => done.push(`${name}=${value}`),
    showGain: (name) => done.push(`show ${name}`),
    startScenario: (name) => done.push(`fly ${name}`),
    locked: false,
    choices: [{ text: "Charts: window of 60 s", run: () => done.push("60 s") }],
    verbs: [{ word: "seed", unit: "", min: 0, max: 9, tunes: false, describe: (seed) => `Restart with seed ${seed}`, run: (seed) => done.push(`seed ${seed}`) }],
  };
  const first = (query: string): string | undefined => {
    done.length = 0;
    itemsFor(query, sources)[0]?.run();
    return done[0];
  };

  it("sets a gain by name, by symbol or by its letter's name", () => {
    expect(["damping.z 12", "damping.z=12", "Λ z 12", "lambda z 12", "damping.z −3"].map(first)).toEqual(["damping.z=12", "damping.z=12", "damping.z=12", "damping.z=12", "damping.z=-3"]);
  });

  it("says what is allowed instead of asking for the impossible", () => {
    const [item] = itemsFor("damping.z 99", sources);
    expect([item?.usable, item?.hint]).toEqual([false, "allowed: 0 to 60"]);
    expect(itemsFor("damping.z 60", sources)[0]?.usable).toBe(true);
    expect(itemsFor("seed 10", sources)[0]?.usable).toBe(false);
  });

  it("sets nothing while what is shown is old, and says why", () => {
    const [item] = itemsFor("damping.z 12", { ...sources, locked: true });
    expect([item?.usable, item?.hint]).toEqual([false, "locked: what you see is old"]);
    expect(itemsFor("seed 7", { ...sources, locked: true })[0]?.usable).toBe(true);
  });

  it("runs commands, scenarios, verbs and shows gains", () => {
    expect(["pau", "hover", "seed 7", "window 60 s", "damping.q1", "lambda q"].map(first)).toEqual(["pause", "fly hover", "seed 7", "60 s", "show damping.q1", "show damping.q1"]);
  });

  it("offers nothing that does not apply, and nothing that is only a key", () => {
    const texts = itemsFor("", sources).map(({ text }) => text);
    expect(texts).toContain("Flight: pause or continue");
    expect(texts.filter((text) => /nothing|palette/.test(text))).toEqual([]);
  });

  it("spells Greek", () => {
    expect(["Λ z", "σ̂(0)", "σ₀", "Φ q₁", "r̂ low-pass"].map(spelled)).toEqual(["lambda z", "sigma(0)", "sigma0", "phi q1", "r low-pass"]);
  });
});
