import { Box3, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import type { ShapeInfo } from "../protocol";
import { meshesOf } from "./shapes";

/** Tolerance of a few roundings, because corners are stored as f32. */
const ROUNDING = 1e-6;

function box(size_m: [number, number, number], position: [number, number, number], alpha = 1, quaternion_wxyz: [number, number, number, number] = [1, 0, 0, 0]): ShapeInfo {
  return { shape: { kind: "box", size_m }, position, quaternion_wxyz, rgba: [1, 0, 0, alpha] };
}

describe("meshesOf", () => {
  it("makes one mesh of all opaque shapes, each where it was", () => {
    const quarter = Math.SQRT1_2;
    const meshes = meshesOf([box([2, 0.2, 0.2], [1, 0, 0]), box([2, 0.2, 0.2], [0, 1, 0], 1, [quarter, 0, 0, quarter]), { shape: { kind: "cylinder", radius_m: 0.1, length_m: 4 }, position: [0, 0, 1], quaternion_wxyz: [1, 0, 0, 0], rgba: [0, 0, 1, 1] }]);
    expect(meshes).toHaveLength(1);
    // Computed by hand: the first bar spans x from 0 to 2; the second, turned by 90 degrees, y from 0 to 2; the cylinder z from -1 to 3.
    const bounds = new Box3().setFromObject(meshes[0]!);
    expect(bounds.min.distanceTo(new Vector3(-0.1, -0.1, -1))).toBeLessThan(ROUNDING);
    expect(bounds.max.distanceTo(new Vector3(2, 2, 3))).toBeLessThan(ROUNDING);
  });

  it("keeps what can be seen through, and meshes, by themselves", () => {
    const mesh: ShapeInfo = { shape: { kind: "mesh", vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]] }, position: [0, 0, 0], quaternion_wxyz: [1, 0, 0, 0], rgba: [1, 1, 1, 1] };
    expect(meshesOf([box([1, 1, 1], [0, 0, 0]), box([1, 1, 1], [0, 0, 2], 0.5), mesh])).toHaveLength(3);
    expect(meshesOf([])).toEqual([]);
  });
});
