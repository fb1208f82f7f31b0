import { PerspectiveCamera, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { fitView, isInView } from "./framing";

const DIRECTION = new Vector3(-0.6, -0.7, 0.4);
const POINTS = [
  [-1.8, -0.3, 0], [-1.2, 0.3, 1.4], [2, 0.4, 0.55], [1.2, -0.4, 0.9],
].map(([x, y, z]) => new Vector3(x, y, z));

function standing(aspect: number): PerspectiveCamera {
  const camera = new PerspectiveCamera(40, aspect, 0.02, 200);
  camera.up.set(0, 0, 1);
  const { target, position } = fitView(POINTS, DIRECTION, camera);
  camera.position.copy(position);
  camera.lookAt(target);
  camera.updateMatrixWorld();
  return camera;
}

describe("fitView", () => {
  // The projection of three.js is the oracle: every point must be inside the picture, and at least one point at its rim.
  it.each([0.6, 1, 2.4])("shows every point, none farther away than needed, at aspect %f", (aspect) => {
    const camera = standing(aspect);
    const seen = POINTS.map((point) => point.clone().project(camera));
    const farthest = Math.max(...seen.map(({ x, y }) => Math.max(Math.abs(x), Math.abs(y))));
    expect(farthest).toBeLessThanOrEqual(0.92 + 1e-6);
    expect(farthest).toBeGreaterThan(0.92 - 1e-6);
  });

  it("looks along the direction it was given", () => {
    const { target, position } = fitView(POINTS, DIRECTION, { fov: 40, aspect: 1 });
    const along = position.clone().sub(target).normalize();
    expect(along.dot(DIRECTION.clone().normalize())).toBeCloseTo(1, 9);
  });
});

describe("isInView", () => {
  it("tells a point in the picture from one beside and one behind", () => {
    const camera = standing(1);
    expect(isInView(camera, new Vector3(0, 0, 0.7))).toBe(true);
    expect(isInView(camera, new Vector3(0, 30, 0.7))).toBe(false);
    expect(isInView(camera, camera.position.clone().addScaledVector(DIRECTION, 3))).toBe(false);
  });
});
