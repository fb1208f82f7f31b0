import { Vector3 } from "three";
import { describe, expect, it } from "vitest";
import type { SceneRotor } from "../protocol";
import { Rotors } from "./rotors";

const rotor = (x: number, spin: number): SceneRotor => ({ position_in_body: [x, 0, 0.1], radius_m: 0.2, spin });
/** Corners of the blades of a rotor, the last ones of the mesh. */
const BLADE_CORNERS = 16;

function blades(rotors: Rotors, index: number, of: number): { corners: Vector3[]; alphas: number[] } {
  const geometry = rotors.meshes[0]?.geometry;
  const [places, colors] = [geometry?.getAttribute("position"), geometry?.getAttribute("color")];
  if (places === undefined || colors === undefined) throw new Error("no mesh");
  const first = places.count - (of - index) * BLADE_CORNERS;
  const numbers = Array.from({ length: BLADE_CORNERS }, (_, k) => first + k);
  return { corners: numbers.map((k) => new Vector3(places.getX(k), places.getY(k), places.getZ(k))), alphas: numbers.map((k) => colors.getW(k)) };
}

describe("Rotors", () => {
  it("are one mesh, and none without rotors", () => {
    expect(new Rotors([rotor(1, 1), rotor(-1, -1)], "#fff").meshes.length).toBe(1);
    expect(new Rotors([], "#fff").meshes.length).toBe(0);
  });

  it("turn around their hubs, each its own way, and show no blades where thrust is unknown", () => {
    const hubs = [new Vector3(1, 0, 0.1), new Vector3(-1, 0, 0.1), new Vector3(0, 0, 0.1)];
    const rotors = new Rotors([rotor(1, 1), rotor(-1, -1), rotor(0, 1)], "#fff");
    const values = new Float32Array([9, 4, 4, NaN]);
    rotors.turn(0, values, 1);
    const before = hubs.map((_, i) => blades(rotors, i, 3));
    rotors.turn(0.05, values, 1);
    const turned = hubs.map((hub, i) => {
      const after = blades(rotors, i, 3);
      const [a, b] = [before[i]?.corners[1]?.clone().sub(hub), after.corners[1]?.clone().sub(hub)];
      if (a === undefined || b === undefined) throw new Error("no corner");
      expect(b.length()).toBeCloseTo(a.length(), 6);
      return Math.atan2(a.x * b.y - a.y * b.x, a.dot(b));
    });
    // The rotor makes 0.6 turns per second at 1 N and twice as many at 4 N, for 0.05 s.
    const angle = 0.6 * 2 * 0.05 * 2 * Math.PI;
    expect(turned[0]).toBeCloseTo(angle, 5);
    expect(turned[1]).toBeCloseTo(-angle, 5);
    expect(turned[2]).toBe(0);
    expect(blades(rotors, 0, 3).alphas.every((alpha) => alpha > 0)).toBe(true);
    expect(blades(rotors, 2, 3).alphas.every((alpha) => alpha === 0)).toBe(true);
  });
});
