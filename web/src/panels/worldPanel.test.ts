import { describe, expect, it } from "vitest";
import { heldText } from "./worldPanel";

describe("heldText", () => {
  it("tells from the force on the pads whether the hand holds the payload, and nothing where nobody knows", () => {
    expect([40, 0, NaN].map(heldText)).toEqual(["held", "not held", ""]);
  });
});
