// Corner brackets around one body that the pointer is over or that is chosen. They move with the body and show through other bodies.
import { BufferGeometry, Float32BufferAttribute, LineBasicMaterial, LineSegments } from "three";
import { MARKS_LAYER } from "./layers";
import type { Body } from "./bodies";

/** Gap between body and bracket, m. */
const GAP_M = 0.008;
/** Share of an edge that a bracket's arm takes. */
const ARM = 0.22;

/** Line segments along the twelve edges of the box around `body`, near the ends of each edge; pairs of points in the body's frame. */
export function bracketPoints({ box }: Pick<Body, "box">): number[] {
  const low = [box.min.x - GAP_M, box.min.y - GAP_M, box.min.z - GAP_M];
  const high = [box.max.x + GAP_M, box.max.y + GAP_M, box.max.z + GAP_M];
  const points: number[] = [];
  for (let corner = 0; corner < 8; corner += 1) {
    const at = [0, 1, 2].map((axis) => ((corner >> axis) & 1 ? high[axis] : low[axis]) ?? 0);
    for (let axis = 0; axis < 3; axis += 1) {
      const arm = [...at];
      const edge = (high[axis] ?? 0) - (low[axis] ?? 0);
      arm[axis] = (at[axis] ?? 0) + ((corner >> axis) & 1 ? -1 : 1) * ARM * edge;
      points.push(...at, ...arm);
    }
  }
  return points;
}

export class Brackets {
  readonly lines: LineSegments<BufferGeometry, LineBasicMaterial>;
  private shown: Body | undefined;

  constructor(color: string, opacity: number) {
    this.lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color, opacity, depthTest: false, transparent: true }));
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 2;
    this.lines.layers.set(MARKS_LAYER);
  }

  get body(): Body | undefined {
    return this.shown;
  }

  /** Puts the brackets around `body`, or hides them; returns true if that changes the picture. */
  surround(body: Body | undefined): boolean {
    if (body === this.shown) return false;
    this.shown = body;
    this.lines.removeFromParent();
    if (body === undefined) return true;
    this.lines.geometry.setAttribute("position", new Float32BufferAttribute(bracketPoints(body), 3));
    body.object.add(this.lines);
    return true;
  }

  recolor(color: string): void {
    this.lines.material.color.set(color);
  }
}
