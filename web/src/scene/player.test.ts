import { describe, expect, it } from "vitest";
import { Store } from "../data/store";
import type { Telemetry } from "../link/decode";
import type { Hello } from "../protocol";
import { ScenePlayer } from "./player";

const hello = { schema_id: 1, tick_s: 0.01, channels: [{ name: "rotor.0" }], events: [], forks: [], state: {} } as unknown as Hello;

function flown(ticks: number): { store: Store; player: ScenePlayer; did: string[]; newest: () => Telemetry | undefined } {
  const store = new Store();
  store.accept(hello);
  for (let tick = 0; tick < ticks; tick += 1) {
    store.ingest({
      schemaId: 1, firstTick: tick, rows: 1, channelCount: 1, gap: 0, reset: false, tSim: 0, tWall: 0, channels: Float32Array.of(tick / 2),
      poses: Float32Array.of(tick, 0, 0, 1, 0, 0, 0), reference: new Float32Array(7), contacts: new Float32Array(), spectrum: new Float32Array(),
    });
  }
  const did: string[] = [];
  let newest: Telemetry | undefined;
  const screen = {
    settings: { trailS: 0.2 },
    update: (frame: Telemetry) => {
      newest = frame;
      did.push(`on ${frame.firstTick}`);
    },
    retrace: (path: (point: (timeS: number, poses: Float32Array) => void) => void, frame: Telemetry) => {
      const points: number[] = [];
      path((timeS) => points.push(Math.round(timeS * 100)));
      newest = frame;
      did.push(`jump ${frame.firstTick} after ${points.join(" ")}`);
    },
    conceal: (hidden: boolean) => hidden && did.push("hidden"),
  };
  return { store, player: new ScenePlayer(store, () => screen), did, newest: () => newest };
}

describe("ScenePlayer", () => {
  it("shows bodies and channels of the tick, with the path of the time before it", () => {
    const { player, did, newest } = flown(200);
    player.show(100);
    // The path of 0.2 s has every fourth tick; a tick's time is that of its end.
    expect(did).toEqual(["jump 100 after 81 85 89 93 97"]);
    expect([newest()?.poses[0], newest()?.channels[0]]).toEqual([100, 50]);
  });

  it("goes on along the path after a short way, and draws it anew after a long way and after a way back", () => {
    const { player, did } = flown(400);
    for (const tick of [100, 101, 120, 300, 299]) player.show(tick);
    expect(did.map((text) => text.split(" ").slice(0, 2).join(" "))).toEqual(["jump 100", "on 101", "on 120", "jump 300", "jump 299"]);
  });

  it("hides the bodies where the page has no picture, and says so", () => {
    const { store, player, did } = flown(50);
    store.pictures.clear();
    expect(player.show(20)).toBe(false);
    expect(did).toEqual(["hidden"]);
  });
});
