import { describe, expect, it } from "vitest";
import type { StateInfo } from "../protocol";
import { StateLog } from "./stateLog";

const state = (tick: number, payload_kg: number): StateInfo => ({ tick, payload_kg, wind_m_s: [0, 0, 0], effects_off: [] }) as unknown as StateInfo;

describe("StateLog", () => {
  it("has the world that was in force at a tick, and none from before the first state", () => {
    const log = new StateLog();
    [state(100, 0.3), state(140, 0.3), state(180, 0.5)].forEach((told) => log.put(told));
    expect([100, 179, 180, 999].map((tick) => log.at(tick)?.payload_kg)).toEqual([0.3, 0.3, 0.5, 0.5]);
    expect(log.at(99)).toBeNull();
  });

  it("forgets what came later when a recording is played from an earlier moment", () => {
    const log = new StateLog();
    [state(100, 0.3), state(900, 0.5), state(200, 0.4)].forEach((told) => log.put(told));
    expect(log.at(950)?.payload_kg).toBe(0.4);
  });
});
