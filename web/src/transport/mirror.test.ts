import { beforeEach, describe, expect, it, vi } from "vitest";
import { Store } from "../data/store";
import type { ClientMessage, Hello, MirrorInfo, StateInfo } from "../protocol";
import { MirrorTransport } from "./mirror";

const info = { file: "a.mcap", live: false, duration_s: 12, phases: [] } as unknown as MirrorInfo;
let store: Store;
let asked: ClientMessage[];
let transport: MirrorTransport;

/** The flight stands at `tick`, and is played or not. */
function stand(tick: number, phase: StateInfo["phase"]): void {
  store.lastTick = tick;
  store.state = { tick, phase, speed: 1 } as StateInfo;
}

beforeEach(() => {
  vi.useFakeTimers();
  store = new Store();
  store.accept({ schema_id: 1, tick_s: 0.01, channels: [], events: [], forks: [], state: {} } as unknown as Hello);
  asked = [];
  transport = new MirrorTransport(store, info, (message) => asked.push(message), () => ({ from: 3, to: 5 }));
});

describe("the playhead of a mirrored recording", () => {
  it("is asked of the server, within the recording, and shows the wish until the flight has come there", () => {
    stand(500, "paused");
    transport.seek(99);
    expect(asked).toEqual([{ type: "seek", t_s: 12 }]);
    expect(transport.timeS).toBe(12);
    stand(1199, "paused");
    transport.arrived(info);
    expect(transport.timeS).toBeCloseTo(11.99);
  });

  it("asks seldom while it is dragged, and last for the place where it was let go", () => {
    stand(500, "flying");
    for (let t = 0; t <= 10; t += 1) transport.seek(t);
    vi.runAllTimers();
    const times = asked.flatMap((message) => (message.type === "seek" ? [message.t_s] : []));
    expect(times[0]).toBe(0);
    expect(times.at(-1)).toBe(10);
    expect(times.length).toBeLessThan(4);
  });

  it("plays the marked stretch again and again", () => {
    transport.toggleLoop();
    stand(400, "flying");
    transport.frame();
    expect(asked).toEqual([]);
    stand(500, "flying");
    transport.frame();
    expect(asked).toEqual([{ type: "seek", t_s: 3 }]);
  });

  it("goes on from the pause at the end, if the loop reaches to there", () => {
    transport = new MirrorTransport(store, info, (message) => asked.push(message), () => null);
    transport.toggleLoop();
    stand(1199, "flying");
    transport.frame();
    expect(asked).toEqual([]);
    stand(1199, "paused");
    transport.frame();
    expect(asked).toEqual([{ type: "seek", t_s: 0 }, { type: "pause", paused: false }]);
  });

  it("stops for a step back", () => {
    stand(500, "flying");
    transport.step(-0.01);
    expect(asked).toEqual([{ type: "pause", paused: true }, { type: "seek", t_s: 4.99 }]);
  });
});
