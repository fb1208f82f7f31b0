import { describe, expect, it } from "vitest";
import type { Hello } from "../protocol";
import { magnitude, rangeOf, scaled } from "./ranges";

const mass = { name: "payload_mass", unit: "kg", help: "mass of the payload", min: 0.001, max: 2, step: 0.01, messages: ["disturb.payload_mass.kg"] };

describe("ranges", () => {
  it("are the server's, and unknown before it has spoken", () => {
    const hello = { quantities: [mass] } as unknown as Hello;
    expect(rangeOf(hello, "payload_mass")).toBe(mass);
    expect(rangeOf(hello, "nose")).toBeNull();
    expect(rangeOf(null, "payload_mass")).toBeNull();
  });

  it("are shown in grams without the rounding of kilograms", () => {
    expect(scaled(mass, 1000)).toEqual({ min: 1, max: 2000, step: 10 });
  });

  it("of a magnitude start at zero", () => {
    expect(magnitude({ min: -30, max: 30, step: 0.5 })).toEqual({ min: 0, max: 30, step: 0.5 });
  });
});
