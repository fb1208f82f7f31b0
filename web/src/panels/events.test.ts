import { describe, expect, it, vi } from "vitest";
import type { EventInfo } from "../protocol";

vi.mock("./dom", () => ({ byId: () => ({}), element: () => ({}) }));
const { continues } = await import("./events");

const event = (t_s: number, text: string, kind = "gain"): EventInfo => ({ tick: 0, t_s, kind, text });

describe("continues", () => {
  it("joins the positions of one slider", () => {
    expect(continues(event(1, "slope.q1 = 3.1"), event(1.2, "slope.q1 = 3.15"))).toBe(true);
    expect(continues(event(1, "Φ z: 3.1 to 3.2"), event(1.2, "Φ z: 3.2 to -4"))).toBe(true);
  });

  it("keeps other gains, later changes and other kinds apart", () => {
    expect(continues(event(1, "slope.q1 = 3.1"), event(1.2, "slope.q2 = 3.1"))).toBe(false);
    expect(continues(event(1, "slope.q1 = 3.1"), event(2.5, "slope.q1 = 3.2"))).toBe(false);
    expect(continues(event(1, "reset 1", "reset"), event(1.1, "reset 2", "reset"))).toBe(false);
  });
});
