import { type InstancedMesh, Matrix4, MeshBasicMaterial, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { Arrows } from "./arrow";

const close = (found: Vector3, wanted: Vector3): void => expect(found.distanceTo(wanted)).toBeLessThan(1e-6);

/** The arrows as drawn: their number, the foot of the first shaft, and the tip of the first head. */
function drawn(arrows: Arrows): { count: number; foot: Vector3; tip: Vector3 } {
  const [shafts, heads] = arrows.root.children as [InstancedMesh, InstancedMesh];
  const corner = (mesh: InstancedMesh, upper: boolean): Vector3 => {
    mesh.geometry.computeBoundingBox();
    const { min, max } = mesh.geometry.boundingBox ?? { min: new Vector3(), max: new Vector3() };
    const matrix = new Matrix4();
    mesh.getMatrixAt(0, matrix);
    return new Vector3(0, upper ? max.y : min.y, 0).applyMatrix4(matrix);
  };
  expect(heads.count).toBe(shafts.count);
  return { count: shafts.count, foot: corner(shafts, false), tip: corner(heads, true) };
}

describe("Arrows", () => {
  it("reach from their foot to the end of their way, thick or thin, long or short", () => {
    const foot = new Vector3(1, -2, 0.5);
    for (const thickness of [1, 2]) {
      for (const way of [new Vector3(0.3, 0.4, 0), new Vector3(0, 0, -0.02), new Vector3(0, -1, 0)]) {
        const arrows = new Arrows(new MeshBasicMaterial(), 2);
        arrows.add(thickness, 0xffffff).show(foot, way);
        arrows.pack();
        const { count, foot: at, tip } = drawn(arrows);
        expect(count).toBe(1);
        close(at, foot);
        close(tip, foot.clone().add(way));
      }
    }
  });

  it("that are unknown, too short or hidden are not among those drawn", () => {
    const arrows = new Arrows(new MeshBasicMaterial(), 4);
    const [unknown, short, hidden, last] = [1, 2, 3, 4].map(() => arrows.add(1, 0xffffff));
    unknown?.show(new Vector3(), new Vector3(NaN, 0, 0));
    short?.show(new Vector3(), new Vector3(0.001, 0, 0));
    hidden?.show(new Vector3(), new Vector3(1, 0, 0));
    hidden?.hide();
    last?.show(new Vector3(5, 0, 0), new Vector3(0, 0, 1));
    arrows.pack();
    const { count, foot } = drawn(arrows);
    expect(count).toBe(1);
    close(foot, new Vector3(5, 0, 0));
    last?.hide();
    arrows.pack();
    expect(drawn(arrows).count).toBe(0);
  });
});
