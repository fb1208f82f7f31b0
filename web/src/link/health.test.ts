import { describe, expect, it } from "vitest";
import { backoffMs, LinkHealth } from "./health";

function connected(at: number): LinkHealth {
  const health = new LinkHealth();
  health.connected = true;
  health.restart(at);
  return health;
}

describe("LinkHealth", () => {
  it("is stale 0.5 s after the last telemetry while flying", () => {
    const health = connected(0);
    health.telemetry(1000, 0);
    expect(health.stale(1499, true)).toBe(false);
    expect(health.stale(1501, true)).toBe(true);
  });

  it("is kept fresh by state messages only while nothing flies", () => {
    const health = connected(0);
    for (let at = 0; at <= 5000; at += 500) health.message(at);
    expect(health.stale(5400, false)).toBe(false);
    expect(health.stale(5400, true)).toBe(true);
  });

  it("is stale as soon as the connection is gone", () => {
    const health = connected(0);
    health.telemetry(10, 0);
    health.connected = false;
    expect(health.stale(11, true)).toBe(true);
  });

  it("counts frames of the last second and the ticks lost", () => {
    const health = connected(0);
    for (let at = 0; at < 3000; at += 20) health.telemetry(at, at === 1000 ? 7 : 0);
    expect(health.framesPerSecond(2990)).toBe(50);
    expect(health.gapTicks).toBe(7);
    expect(health.framesPerSecond(9000)).toBe(0);
  });
});

describe("backoffMs", () => {
  it("goes from 0.25 s to 4 s and stays there", () => {
    expect([0, 1, 2, 3, 4, 5, 99].map(backoffMs)).toEqual([250, 500, 1000, 2000, 4000, 4000, 4000]);
  });
});
