import { describe, expect, it } from "vitest";
import type { EventInfo, GainInfo } from "../protocol";
import { GainLog } from "./gainLog";

const gain = (tick: number, text: string): EventInfo => ({ tick, t_s: tick / 100, kind: "gain", text });

function log(): GainLog {
  const made = new GainLog();
  made.start([{ name: "damping.z", value: 8 }, { name: "leak", value: 2 }] as GainInfo[], 1000);
  return made;
}

describe("GainLog", () => {
  it("has the value that was in force at a tick after the page connected", () => {
    const made = log();
    made.note("damping.z", 9, 1200);
    expect([1000, 1199, 1200, 5000].map((tick) => made.at("damping.z", tick, []))).toEqual([8, 8, 9, 9]);
    expect(made.at("leak", 5000, [])).toBe(2);
  });

  it("goes back before the connection by the events of the flight", () => {
    const events = [gain(300, "Λ z (damping.z) 3.5 -> 6"), gain(700, "Λ z (damping.z) 6 -> 8")];
    expect([299, 300, 699, 700].map((tick) => log().at("damping.z", tick, events))).toEqual([3.5, 6, 6, 8]);
    expect(log().at("leak", 299, events)).toBe(2);
  });

  it("says that it does not know what a preset changed", () => {
    const events = [gain(500, "preset paper (12 gains changed)")];
    expect(log().at("leak", 400, events)).toBeNull();
    expect(log().at("leak", 600, events)).toBe(2);
  });
});
