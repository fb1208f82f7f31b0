import { describe, expect, it } from "vitest";
import { LinkHealth } from "../link/health";
import { FrameRate } from "./frameRate";
import { rowsOf } from "./linkPanel";
import { LossNotice } from "./lossNotice";

describe("link readings", () => {
  it("say what came in the last second", () => {
    const health = new LinkHealth();
    health.open(0);
    for (let at = 0; at < 2000; at += 100) {
      health.bytes(at, 500);
      health.telemetry(at, at === 500 ? 4 : 0);
    }
    const rows = new Map(rowsOf({ health, now: 1990, flying: true, clients: 3, pageFps: 41.6 }).map(([name, value]) => [name, value]));
    expect(rows.get("data")).toBe("5.0 kB/s");
    expect(rows.get("telemetry")).toBe("10 frames/s");
    expect(rows.get("lost ticks")).toBe("4 in 1 gaps");
    expect([rows.get("age of the data"), rows.get("3-D view"), rows.get("clients"), rows.get("reconnects")]).toEqual(["90 ms", "42 pictures/s", "3", "0"]);
  });

  it("count connections after the first, and start the lost ticks anew", () => {
    const health = new LinkHealth();
    health.open(0);
    health.telemetry(10, 5);
    health.connected = false;
    health.open(100);
    expect([health.reconnects, health.gapTicks, health.connected]).toEqual([1, 0, true]);
  });

  it("count the frames of the page", () => {
    const rate = new FrameRate();
    for (let at = 0; at < 3000; at += 25) rate.frame(at);
    expect(rate.at(2999)).toBe(40);
    expect(rate.at(9000)).toBe(0);
  });
});

describe("LossNotice", () => {
  it("adds up what was lost and speaks at most every ten seconds", () => {
    const said: string[] = [];
    const loss = new LossNotice((text) => said.push(text));
    loss.due(0);
    loss.lost(3);
    loss.due(100);
    loss.lost(1);
    loss.lost(6);
    loss.due(5000);
    expect(said.length).toBe(1);
    loss.due(10_200);
    expect(said.map((text) => text.split(" ")[0])).toEqual(["3", "7"]);
  });
});
