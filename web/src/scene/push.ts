// The push as a spring between the grabbed point and the cursor. Its force grows with the distance, up to the force of a firm hand.
// The cursor lies in the plane through the grabbed point that faces the camera.
import { type Camera, Plane, Raycaster, Vector2, Vector3 } from "three";

/** Stiffness of the spring, N per metre between the grabbed point and the cursor. */
export const SPRING_N_PER_M = 30;
/** Largest force of a push, N. The server refuses more than 100 N. */
export const MOST_PUSH_N = 15;

export class PushSpring {
  /** The grabbed point in the world, m. */
  readonly grabbed = new Vector3();
  /** Position of the cursor in the plane, in the world, m. */
  readonly cursor = new Vector3();
  /** Force of the spring in the world, N. */
  readonly force = new Vector3();
  private readonly plane = new Plane();
  private readonly caster = new Raycaster();
  private readonly facing = new Vector3();

  /** Computes the force for the cursor at `ndc` (-1 to 1, y up) in the picture of `camera` and the point `grabbed`. */
  pull(camera: Camera, grabbed: Vector3, ndc: Vector2): void {
    this.grabbed.copy(grabbed);
    camera.updateMatrixWorld();
    camera.getWorldDirection(this.facing);
    this.plane.setFromNormalAndCoplanarPoint(this.facing, grabbed);
    this.caster.setFromCamera(ndc, camera);
    if (this.caster.ray.intersectPlane(this.plane, this.cursor) === null) this.cursor.copy(grabbed);
    this.force.copy(this.cursor).sub(grabbed).multiplyScalar(SPRING_N_PER_M).clampLength(0, MOST_PUSH_N);
  }
}
