// A soft mark on the floor under the vehicle. Without it a reader cannot tell a near and low vehicle from a far and high one.
import { CircleGeometry, Mesh, MeshBasicMaterial, type Vector3 } from "three";

const RADIUS_M = 0.3;
const ABOVE_FLOOR_M = 0.003;
const ALPHA = 0.22;

export class Shadow {
  readonly mesh = new Mesh(new CircleGeometry(RADIUS_M, 32), new MeshBasicMaterial({ color: 0x000000, opacity: ALPHA, transparent: true, depthWrite: false }));

  constructor() {
    this.mesh.visible = false;
  }

  /** Moves the mark under `position`. */
  follow({ x, y }: Vector3): void {
    this.mesh.position.set(x, y, ABOVE_FLOOR_M);
    this.mesh.visible = true;
  }
}
