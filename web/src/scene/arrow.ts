// Arrows with a body: one-pixel lines vanish on a large screen. All arrows of a group are drawn in two calls, their shafts and
// their heads: without a graphics card it is calls that cost.
import { Color, type ColorRepresentation, ConeGeometry, CylinderGeometry, Group, InstancedMesh, type Material, Matrix4, Quaternion, Vector3 } from "three";

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
const turn = new Quaternion();
const size = new Vector3();
const place = new Vector3();
const matrix = new Matrix4();

/** An arrow as drawn: foot (m) and the way to its tip (m), both in the world. */
export interface DrawnArrow {
  foot: number[];
  vector: number[];
}

export class Arrow {
  private readonly foot = new Vector3();
  private readonly direction = new Vector3();
  private length = 0;
  private shown = false;

  constructor(
    private readonly thickness: number,
    readonly color: Color,
  ) {}

  get visible(): boolean {
    return this.shown;
  }

  /** From `foot` by `way`, m; hidden if either is unknown or there is nothing to show. */
  show(foot: Vector3, way: Vector3): void {
    this.length = way.length();
    this.shown = Number.isFinite(this.length + foot.x + foot.y + foot.z) && this.length >= SHORTEST_M;
    if (!this.shown) return;
    this.foot.copy(foot);
    this.direction.copy(way).divideScalar(this.length);
  }

  hide(): void {
    this.shown = false;
  }

  /** What is drawn; null while hidden. */
  drawn(): DrawnArrow | null {
    if (!this.shown) return null;
    return { foot: this.foot.toArray(), vector: this.direction.clone().multiplyScalar(this.length).toArray() };
  }

  /** Writes shaft and head as number `index` of the two. */
  write(shafts: InstancedMesh, heads: InstancedMesh, index: number): void {
    const { thickness } = this;
    const full = HEAD_LENGTH_M * thickness;
    const head = Math.min(1, this.length / (2 * full));
    const shaft = Math.max(1e-4, this.length - head * full);
    turn.setFromUnitVectors(ALONG, this.direction);
    shafts.setMatrixAt(index, matrix.compose(this.foot, turn, size.set(thickness, shaft, thickness)));
    place.copy(this.foot).addScaledVector(this.direction, shaft);
    heads.setMatrixAt(index, matrix.compose(place, turn, size.setScalar(head * thickness)));
    shafts.setColorAt(index, this.color);
    heads.setColorAt(index, this.color);
  }
}

export class Arrows {
  readonly root = new Group();
  private readonly list: Arrow[] = [];
  private readonly shafts: InstancedMesh;
  private readonly heads: InstancedMesh;

  /** Room for `most` arrows of a white `material`. */
  constructor(material: Material, most: number) {
    this.shafts = new InstancedMesh(SHAFT, material, most);
    this.heads = new InstancedMesh(HEAD, material, most);
    for (const part of [this.shafts, this.heads]) {
      part.frustumCulled = false;
      part.count = 0;
      part.setColorAt(0, new Color());
      this.root.add(part);
    }
  }

  add(thickness: number, color: ColorRepresentation): Arrow {
    const arrow = new Arrow(thickness, new Color(color));
    this.list.push(arrow);
    return arrow;
  }

  /** Before drawing: what is visible comes into its place. */
  pack(): void {
    let count = 0;
    for (const arrow of this.list) if (arrow.visible) arrow.write(this.shafts, this.heads, count++);
    for (const part of [this.shafts, this.heads]) {
      part.count = count;
      part.visible = count > 0;
      part.instanceMatrix.needsUpdate = true;
      if (part.instanceColor !== null) part.instanceColor.needsUpdate = true;
    }
  }

  dispose(): void {
    this.root.removeFromParent();
    this.shafts.dispose();
    this.heads.dispose();
  }
}
