import { describe, expect, it } from "vitest";
import { dialDeg } from "./windBadge";

const turn = (deg: number): number => ((deg % 360) + 360) % 360;

describe("dialDeg", () => {
  // For a camera that looks along +y, with x to its right, the dial agrees with a map.
  it.each([[0, 1, 0], [1, 0, 90], [0, -1, 180], [-1, 0, 270], [1, 1, 45]])("shows wind towards (%i, %i) at %i degrees on a map", (x, y, wanted) => {
    expect(turn(dialDeg(x, y, Math.PI / 2))).toBeCloseTo(wanted, 9);
  });

  it("points up for wind that blows the way the camera looks", () => expect(turn(dialDeg(0.6, -0.8, Math.atan2(-0.8, 0.6)))).toBeCloseTo(0, 9));
});
