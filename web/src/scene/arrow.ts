// An arrow with a body: one-pixel lines vanish on a large screen. All arrows share two geometries.
import { ConeGeometry, CylinderGeometry, Group, type Material, Mesh, Vector3 } from "three";

/** Of an arrow of thickness 1, m. */
const SHAFT_RADIUS_M = 0.004;
const HEAD_RADIUS_M = 0.012;
const HEAD_LENGTH_M = 0.035;
/** Shorter arrows would be a blob that tells no direction, m. */
const SHORTEST_M = 0.004;
const ALONG = new Vector3(0, 1, 0);
// Unit height with the foot at the origin, so that length is a scale.
const SHAFT = new CylinderGeometry(SHAFT_RADIUS_M, SHAFT_RADIUS_M, 1, 8).translate(0, 0.5, 0);
const HEAD = new ConeGeometry(HEAD_RADIUS_M, HEAD_LENGTH_M, 12).translate(0, HEAD_LENGTH_M / 2, 0);

/** An arrow as drawn: foot (m) and the way to its tip (m), both in the world. */
export interface DrawnArrow {
  foot: number[];
  vector: number[];
}

export class Arrow {
  readonly root = new Group();
  private readonly shaft: Mesh;
  private readonly head: Mesh;
  private readonly direction = new Vector3();
  private length = 0;

  constructor(
    material: Material,
    private readonly thickness = 1,
  ) {
    this.shaft = new Mesh(SHAFT, material);
    this.head = new Mesh(HEAD, material);
    this.root.add(this.shaft, this.head);
    this.root.visible = false;
  }

  /** From `foot` by `way`, m; hidden if either is unknown or there is nothing to show. */
  show(foot: Vector3, way: Vector3): void {
    this.length = way.length();
    this.root.visible = Number.isFinite(this.length + foot.x + foot.y + foot.z) && this.length >= SHORTEST_M;
    if (!this.root.visible) return;
    const full = HEAD_LENGTH_M * this.thickness;
    const head = Math.min(1, this.length / (2 * full));
    const shaft = Math.max(1e-4, this.length - head * full);
    this.direction.copy(way).divideScalar(this.length);
    this.root.position.copy(foot);
    this.root.quaternion.setFromUnitVectors(ALONG, this.direction);
    this.shaft.scale.set(this.thickness, shaft, this.thickness);
    this.head.scale.setScalar(head * this.thickness);
    this.head.position.y = shaft;
  }

  hide(): void {
    this.root.visible = false;
  }

  /** What is drawn; null while hidden. */
  drawn(): DrawnArrow | null {
    if (!this.root.visible) return null;
    return { foot: this.root.position.toArray(), vector: this.direction.clone().multiplyScalar(this.length).toArray() };
  }
}
