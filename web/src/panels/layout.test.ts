import { describe, expect, it } from "vitest";
import { layoutOf, LAYOUTS } from "./layout";

describe("layouts", () => {
  it("are found by their names, and no other word is one", () => {
    expect(LAYOUTS.map(({ name }) => layoutOf(name))).toEqual(["fly", "tune", "adapt", "replay"]);
    expect([layoutOf(""), layoutOf("Fly"), layoutOf("toString")]).toEqual([null, null, null]);
  });
});
