// An arrow with a body: one-pixel lines vanish on a large screen.
import { ConeGeometry, CylinderGeometry, Group, type Material, Mesh, Vector3 } from "three";

const SHAFT_RADIUS_M = 0.004;
const HEAD_RADIUS_M = 0.012;
const HEAD_LENGTH_M = 0.035;
const ALONG = new Vector3(0, 1, 0);

export class Arrow {
  readonly root = new Group();
  private readonly shaft: Mesh;
  private readonly head: Mesh;

  constructor(material: Material) {
    // Unit height with the foot at the origin, so that length is a scale.
    this.shaft = new Mesh(new CylinderGeometry(SHAFT_RADIUS_M, SHAFT_RADIUS_M, 1, 8).translate(0, 0.5, 0), material);
    this.head = new Mesh(new ConeGeometry(HEAD_RADIUS_M, HEAD_LENGTH_M, 12).translate(0, HEAD_LENGTH_M / 2, 0), material);
    this.root.add(this.shaft, this.head);
  }

  /** From `position` along the unit vector `direction`, m. */
  point(position: Vector3, direction: Vector3, length: number): void {
    const head = Math.min(1, length / (2 * HEAD_LENGTH_M));
    const shaft = Math.max(1e-4, length - head * HEAD_LENGTH_M);
    this.root.position.copy(position);
    this.root.quaternion.setFromUnitVectors(ALONG, direction);
    this.shaft.scale.set(1, shaft, 1);
    this.head.scale.setScalar(head);
    this.head.position.y = shaft;
  }
}
