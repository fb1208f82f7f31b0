// Finds the body under the cursor.
import { type Camera, Raycaster, Vector2, Vector3 } from "three";
import type { Bodies, Body } from "./bodies";

/** A cursor this far beside the vehicle still grabs it, because a vehicle has thin parts, px. */
const GRAB_WITHIN_PX = 40;

export interface Picked {
  body: Body;
  /** The point at which the ray of the cursor meets the body, in the world, m. */
  point: Vector3;
}

export class Picker {
  private readonly caster = new Raycaster();
  private readonly place = new Vector3();

  constructor(
    readonly camera: Camera,
    private readonly canvas: HTMLElement,
  ) {}

  /** Position of a pointer in the picture: -1 to 1, y up. */
  ndc(clientX: number, clientY: number, out: Vector2): Vector2 {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    return out.set(((clientX - left) / width) * 2 - 1, 1 - ((clientY - top) / height) * 2);
  }

  /** Position of a world point on the page, CSS px. */
  onPage(point: Vector3): [number, number] {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    this.place.copy(point).project(this.camera);
    return [left + ((this.place.x + 1) / 2) * width, top + ((1 - this.place.y) / 2) * height];
  }

  /** The nearest body at `ndc`. */
  pick(bodies: Bodies, ndc: Vector2): Picked | undefined {
    this.caster.setFromCamera(ndc, this.camera);
    const hit = this.caster.intersectObject(bodies.root, true)[0];
    if (hit === undefined) return undefined;
    const body = bodies.list().find(({ object }) => {
      for (let part = hit.object; part !== null; part = part.parent as typeof part) if (part === object) return true;
      return false;
    });
    return body === undefined ? undefined : { body, point: hit.point };
  }

  /** The point of the vehicle at `ndc`, or the centre of its nearest link if the cursor is close beside the vehicle. */
  grab(bodies: Bodies, ndc: Vector2, clientX: number, clientY: number): Picked | undefined {
    const hit = this.pick(bodies, ndc);
    if (hit?.body.group === "vehicle") return hit;
    let best: Picked | undefined;
    let nearest = GRAB_WITHIN_PX;
    for (const body of bodies.moving.filter(({ group }) => group === "vehicle")) {
      const point = body.box.getCenter(new Vector3()).applyMatrix4(body.object.matrixWorld);
      const [x, y] = this.onPage(point);
      const away = Math.hypot(x - clientX, y - clientY);
      if (away < nearest) [nearest, best] = [away, { body, point }];
    }
    return best;
  }
}
