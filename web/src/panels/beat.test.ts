import { describe, expect, it } from "vitest";
import { Beat } from "./beat";

describe("Beat", () => {
  it("is due five times a second, and for everybody in the same frame", () => {
    const [one, other] = [new Beat(), new Beat()];
    other.due(0);
    const frames = Array.from({ length: 600 }, (_, k) => 5 + (k * 1000) / 60);
    const beats = frames.filter((now) => one.due(now));
    expect(beats.length).toBe(50);
    expect(frames.filter((now) => other.due(now))).toEqual(beats.slice(1));
  });
});
