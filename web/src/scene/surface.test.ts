import { describe, expect, it } from "vitest";
import { turnOver } from "./surface";

describe("turnOver", () => {
  it("puts the lowest row of WebGL at the bottom of the canvas, and no row on another", () => {
    const rows = Uint8Array.from([1, 2, 3, 4, 5, 6]);
    const canvas = new Uint8ClampedArray(6);
    turnOver(rows, canvas, 2);
    expect([...canvas]).toEqual([5, 6, 3, 4, 1, 2]);
  });
});
