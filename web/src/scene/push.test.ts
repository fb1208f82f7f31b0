import { PerspectiveCamera, Vector2, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { MOST_PUSH_N, PushSpring, SPRING_N_PER_M } from "./push";

/** Tolerance for a double that was projected and unprojected. */
const ROUNDING = 1e-9;

function camera(): PerspectiveCamera {
  const made = new PerspectiveCamera(40, 1.6, 0.02, 200);
  made.up.set(0, 0, 1);
  made.position.set(-3, -4, 2.5);
  made.lookAt(-1.5, 0, 1);
  made.updateMatrixWorld();
  return made;
}

/** Position to which three.js projects `point`. */
function seen(point: Vector3, by: PerspectiveCamera): Vector2 {
  const { x, y } = point.clone().project(by);
  return new Vector2(x, y);
}

describe("PushSpring", () => {
  const grabbed = new Vector3(-1.4, 0.1, 1.2);

  it.each([[0.2, 0], [0, -0.3], [-0.15, 0.25]])("pushes with the spring's stiffness towards a point %f m right and %f m up in the picture", (right, up) => {
    const eye = camera();
    const along = new Vector3().addScaledVector(new Vector3().setFromMatrixColumn(eye.matrixWorld, 0), right).addScaledVector(new Vector3().setFromMatrixColumn(eye.matrixWorld, 1), up);
    const spring = new PushSpring();
    spring.pull(eye, grabbed, seen(grabbed.clone().add(along), eye));
    expect(spring.force.distanceTo(along.multiplyScalar(SPRING_N_PER_M))).toBeLessThan(ROUNDING * SPRING_N_PER_M);
  });

  it("holds the direction and stops at its limit when the cursor is far away", () => {
    const eye = camera();
    const right = new Vector3().setFromMatrixColumn(eye.matrixWorld, 0);
    const spring = new PushSpring();
    spring.pull(eye, grabbed, seen(grabbed.clone().addScaledVector(right, 2), eye));
    expect(spring.force.distanceTo(right.multiplyScalar(MOST_PUSH_N))).toBeLessThan(1e-6);
  });

  it("does not push while the cursor is on the grabbed point", () => {
    const eye = camera();
    const spring = new PushSpring();
    spring.pull(eye, grabbed, seen(grabbed, eye));
    expect(spring.force.length()).toBeLessThan(1e-6);
  });
});
