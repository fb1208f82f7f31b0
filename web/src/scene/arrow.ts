// Solid arrows, because lines of one pixel vanish on a large screen. One call draws all shafts of a group and one call all heads,
// because without a graphics card the number of calls decides the cost.
import { Color, type ColorRepresentation, ConeGeometry, CylinderGeometry, Group, InstancedMesh, type Material, Matrix4, Quaternion, Vector3 } from "three";

/** Sizes of an arrow of thickness 1, m. */
const SHAFT_RADIUS_M = 0.004;
const HEAD_RADIUS_M = 0.012;
const HEAD_LENGTH_M = 0.035;
/** Shorter arrows are not drawn, because they would look like dots without a direction, m. */
const SHORTEST_M = 0.004;
const ALONG = new Vector3(0, 1, 0);
// The shaft has height 1 and its foot at the origin, so that scaling sets its length.
const SHAFT = new CylinderGeometry(SHAFT_RADIUS_M, SHAFT_RADIUS_M, 1, 8).translate(0, 0.5, 0);
const HEAD = new ConeGeometry(HEAD_RADIUS_M, HEAD_LENGTH_M, 12).translate(0, HEAD_LENGTH_M / 2, 0);
const turn = new Quaternion();
const size = new Vector3();
const place = new Vector3();
const matrix = new Matrix4();

/** An arrow as drawn: foot (m) and the vector from foot to tip (m), both in the world. */
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

  /** Shows the arrow from `foot` to `foot + way`, m; hides it if either is unknown or the arrow is too short. */
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

  /** The arrow as drawn; null while it is hidden. */
  drawn(): DrawnArrow | null {
    if (!this.shown) return null;
    return { foot: this.foot.toArray(), vector: this.direction.clone().multiplyScalar(this.length).toArray() };
  }

  /** Writes the shaft and the head as instance `index` of both meshes. */
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

  /** Makes room for `most` arrows; `material` must be white. */
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

  /** Writes the visible arrows into the meshes; call it before drawing. */
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
