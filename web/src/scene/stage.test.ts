import { describe, expect, it } from "vitest";
import { pixelRatio } from "./stage";

describe("pixelRatio", () => {
  it("is the screen's with a graphics card, up to 2", () => {
    expect([1, 1.5, 3].map((screen) => pixelRatio(false, 900, 900, screen))).toEqual([1, 1.5, 2]);
  });

  it("is 1 without one, and less where the view has more than 400,000 pixels", () => {
    expect(pixelRatio(true, 500, 500, 2)).toBe(1);
    const ratio = pixelRatio(true, 1000, 1000, 2);
    expect((1000 * ratio) ** 2).toBeCloseTo(400_000, 3);
  });
});
