import { describe, expect, it } from "vitest";
import { handReading } from "./handReading";

describe("handReading", () => {
  const reading = (values: Record<string, number>): string => handReading({ shown: (name) => values[name] ?? NaN });

  it("gives the opening in millimetres and the grip in newtons", () => {
    expect(reading({ opening_m: 0.0504, grip_force_n: 39.96 })).toBe("open 50 mm · grip 40.0 N");
  });

  it("leaves out what is unknown", () => {
    expect(reading({ opening_m: 0.11 })).toBe("open 110 mm");
    expect(reading({})).toBe("");
  });
});
