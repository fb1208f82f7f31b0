// The way something came, as one line of bounded length.
import { BufferAttribute, BufferGeometry, Line, LineBasicMaterial, type ColorRepresentation } from "three";
import { MARKS_LAYER } from "./layers";

const POINTS = 1200;
/** Points closer than this add nothing to the picture, m. */
const SPACING_M = 0.01;

export class Trail {
  readonly line: Line<BufferGeometry, LineBasicMaterial>;
  private readonly points = new Float32Array(POINTS * 3);
  private readonly attribute = new BufferAttribute(this.points, 3);
  private count = 0;

  constructor(color: ColorRepresentation) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.attribute);
    geometry.setDrawRange(0, 0);
    this.line = new Line(geometry, new LineBasicMaterial({ color }));
    this.line.frustumCulled = false;
    this.line.layers.set(MARKS_LAYER);
  }

  add(x: number, y: number, z: number): void {
    if (!Number.isFinite(x + y + z)) return;
    const last = (this.count - 1) * 3;
    if (this.count > 0 && Math.hypot(x - (this.points[last] ?? 0), y - (this.points[last + 1] ?? 0), z - (this.points[last + 2] ?? 0)) < SPACING_M) return;
    if (this.count === POINTS) {
      this.points.copyWithin(0, 3);
      this.count -= 1;
    }
    this.points.set([x, y, z], this.count * 3);
    this.count += 1;
    this.attribute.needsUpdate = true;
    this.line.geometry.setDrawRange(0, this.count);
  }

  clear(): void {
    this.count = 0;
    this.line.geometry.setDrawRange(0, 0);
  }
}
