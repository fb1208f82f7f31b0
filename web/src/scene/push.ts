// The push as a spring between the grabbed point and the cursor: stronger the farther, up to a limit that a hand would
// give. The cursor is taken in the plane through the grabbed point that faces the camera.
import { type Camera, Plane, Raycaster, Vector2, Vector3 } from "three";

/** N per metre between the grabbed point and the cursor. */
export const SPRING_N_PER_M = 30;
/** A firm shove; the server refuses more than 100 N. */
export const MOST_PUSH_N = 15;

export class PushSpring {
  /** Grabbed point in the world, m. */
  readonly grabbed = new Vector3();
  /** Where the cursor is in the plane, m. */
  readonly cursor = new Vector3();
  /** In the world, N. */
  readonly force = new Vector3();
  private readonly plane = new Plane();
  private readonly caster = new Raycaster();
  private readonly facing = new Vector3();

  /** The cursor is at `ndc` (-1 to 1, y up) in the picture of `camera`, the grabbed point at `grabbed`. */
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
