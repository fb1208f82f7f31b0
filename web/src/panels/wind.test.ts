import { describe, expect, it } from "vitest";
import { compassPoint, windForm, windText, windVector } from "./wind";

describe("wind", () => {
  it("from the west blows east, from the north blows south (world: x east, y north)", () => {
    expect(windVector({ speed: 3, from: 270, up: 0 })).toEqual([3, 0, 0]);
    expect(windVector({ speed: 3, from: 0, up: 0 })).toEqual([0, -3, 0]);
    expect(windVector({ speed: 2, from: 225, up: -1 })).toEqual([1.41, 1.41, -1]);
  });

  it("comes back as it was said", () => {
    for (const from of [0, 30, 90, 145, 200, 270, 355]) {
      const back = windForm(windVector({ speed: 6, from, up: 0.5 }), 0);
      expect(back.from).toBe(from);
      // The tolerance covers the rounding of the vector to a hundredth.
      expect(back.speed).toBeCloseTo(6, 1);
      expect(back.up).toBe(0.5);
    }
  });

  it("keeps the bearing of a calm", () => {
    expect(windForm([0, 0, 0], 145)).toEqual({ speed: 0, from: 145, up: 0 });
  });

  it("is named by the nearest point of the compass", () => {
    expect([0, 44, 46, 180, 359, 270].map(compassPoint)).toEqual(["N", "NE", "NE", "S", "N", "W"]);
    expect([windText([0, 0, 0]), windText([3, 0, 0]), windText([0, 0, -2])]).toEqual(["calm", "3.0 m/s from W", "2.0 m/s down"]);
  });
});
