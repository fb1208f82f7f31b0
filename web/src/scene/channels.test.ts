import { describe, expect, it } from "vitest";
import type { Telemetry } from "../link/decode";
import type { ChannelInfo } from "../protocol";
import { SceneChannels } from "./channels";

const infos = (...names: string[]): ChannelInfo[] => names.map((name) => ({ name }) as ChannelInfo);

function frame(rows: number[][]): Telemetry {
  return { rows: rows.length, channelCount: rows[0]?.length ?? 0, channels: Float32Array.from(rows.flat()) } as Telemetry;
}

function picked(channels: SceneChannels, from: Telemetry): number[] {
  const out = new Float32Array(2 + channels.count);
  channels.pick(from, out, 2);
  return [...out.slice(2)];
}

describe("SceneChannels", () => {
  const known = infos("r_hat.x", "r_hat.y", "r_hat.z", "rotor.1", "adapted.x", "adapted.y", "adapted.z", "base.x", "base.y", "base.z", "rotor.0", "wind.x", "wind.y", "wind.z");

  it("picks the newest row by name, and the adapter's share as the difference", () => {
    const channels = new SceneChannels(known, 2);
    expect(picked(channels, frame([new Array(14).fill(99), [5, 6, 33, 7, 1, 2, 34, 1, 1, 30, 8, 3, 0, -1]]))).toEqual([8, 7, 5, 6, 33, 0, 1, 4, 3, 0, -1]);
  });

  it("shows the estimate in force, not the forecast it is made of", () => {
    const channels = new SceneChannels(infos("adapted.x", "adapted.y", "adapted.z", "r_hat.x", "r_hat.y", "r_hat.z"), 0);
    expect(picked(channels, frame([[1, 2, 3, 4, 5, 6]])).slice(0, 3)).toEqual([4, 5, 6]);
  });

  it("knows nothing of channels that are not sent, nor from a frame without rows", () => {
    const channels = new SceneChannels(infos("rotor.0"), 1);
    expect(picked(channels, frame([[5]]))).toEqual([5, ...new Array(9).fill(NaN)]);
    expect(picked(channels, frame([]))).toEqual(new Array(10).fill(NaN));
  });
});
