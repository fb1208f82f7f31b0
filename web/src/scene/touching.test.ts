import { Box3, Matrix4, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import type { SceneGroup } from "../protocol";
import { contactForceOn, type Touchable } from "./touching";

function block(group: SceneGroup, middle: [number, number, number], half: [number, number, number]): Touchable {
  const box = new Box3(new Vector3(...half).negate(), new Vector3(...half));
  return { group, box, worldInverse: new Matrix4().makeTranslation(...middle).invert() };
}

// A cube of 5 cm stands on a table, and a finger presses on its +y face. The other end of the finger touches nothing.
const cube = block("payload", [1, 0, 0.525], [0.025, 0.025, 0.025]);
const table = block("arena", [1, 0, 0.25], [0.4, 0.4, 0.25]);
const finger = block("vehicle", [1, 0.03, 0.54], [0.02, 0.005, 0.03]);
const CONTACTS = Float32Array.from([
  ...[1.02, 0.02, 0.5, 0, 0, 2],
  ...[0.98, -0.02, 0.5, 0, 0, 1],
  ...[1, 0.025, 0.53, 0, -20, 0],
]);

describe("contactForceOn", () => {
  const forceOn = (body: Touchable): { force: number[]; points: number } => {
    const out = new Vector3();
    const points = contactForceOn(body, cube, CONTACTS, out);
    return { force: out.toArray(), points };
  };

  it("adds what the payload receives", () => expect(forceOn(cube)).toEqual({ force: [0, -20, 3], points: 3 }));
  it("gives table and finger what the payload gives back", () => {
    expect(forceOn(table).points).toBe(2);
    expect(forceOn(table).force[2]).toBe(-3);
    expect(forceOn(finger)).toEqual({ force: [0, 20, 0], points: 1 });
  });
  it("gives the vehicle what it receives itself from anything but the payload", () => {
    const leg = block("vehicle", [1.3, 0, 0.51], [0.01, 0.01, 0.01]);
    const out = new Vector3();
    expect(contactForceOn(leg, cube, Float32Array.from([1.3, 0, 0.5, 0, 0, 7]), out)).toBe(1);
    expect(out.z).toBe(7);
  });
  it("leaves out what touches elsewhere", () => expect(forceOn(block("vehicle", [0, 0, 2], [0.1, 0.1, 0.1]))).toEqual({ force: [0, 0, 0], points: 0 }));
});
