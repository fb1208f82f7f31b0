import { describe, expect, it } from "vitest";
import type { EventInfo } from "../protocol";
import { atEffect, gainChange, joined } from "./gainEvents";

const gain = (tick: number, text: string, kind = "gain"): EventInfo => ({ tick, t_s: tick / 100, kind, text });

describe("events about gains", () => {
  it("are told at the tick since which the value is in force, not at the tick at which the slider had come to rest", () => {
    const told = atEffect(gain(650, "Λ z (damping.z) 3.6 -> 8.5 since tick 598"), 0.01);
    expect(told.tick).toBe(598);
    expect(told.t_s).toBeCloseTo(5.98, 9);
    expect(told.text).toBe("Λ z (damping.z) 3.6 -> 8.5");
    const plain = gain(3, "preset tuned (5 gains changed)");
    expect(atEffect(plain, 0.01)).toBe(plain);
  });

  it("of one drag are one line, with the first value, the last value, and the time of the last", () => {
    const both = joined(gain(500, "Λ z (damping.z) 3.5 -> 3.6"), gain(598, "Λ z (damping.z) 3.6 -> 8.5"));
    expect(both?.text).toBe("Λ z (damping.z) 3.5 -> 8.5");
    expect(both?.tick).toBe(598);
  });

  it("of other gains, of another kind, or that do not go on where the last ended, stay apart", () => {
    const first = gain(500, "Λ z (damping.z) 3.5 -> 3.6");
    expect(joined(first, gain(510, "Λ y (damping.y) 3.6 -> 8.5"))).toBeNull();
    expect(joined(first, gain(510, "Λ z (damping.z) 4 -> 8.5"))).toBeNull();
    expect(joined(first, gain(5000, "Λ z (damping.z) 3.6 -> 8.5"))).toBeNull();
    expect(joined(gain(1, "reset 1", "reset"), gain(2, "reset 2", "reset"))).toBeNull();
    expect(gainChange("preset tuned (5 gains changed)")).toBeNull();
  });
});
