// Assigns contact forces to bodies. Telemetry gives points and forces without names; a point belongs to the bodies whose boxes
// contain it. The given force acts on the payload; in a contact without the payload it acts on the vehicle.
import { type Box3, type Matrix4, Vector3 } from "three";
import type { SceneGroup } from "../protocol";

const CONTACT_FLOATS = 6;
/** Contact points may lie this far outside of a box, because the solver allows some distance from the surface, m. */
const MARGIN_M = 0.004;

/** The properties of a body that contacts need: its box in its own frame. */
export interface Touchable {
  group: SceneGroup;
  box: Box3;
  worldInverse: Matrix4;
}

const point = new Vector3();

export function touches({ box, worldInverse }: Touchable, x: number, y: number, z: number): boolean {
  point.set(x, y, z).applyMatrix4(worldInverse);
  return box.distanceToPoint(point) <= MARGIN_M;
}

/** Writes the sum of the contact forces on `body` into `out`, in the world, N; returns the number of their points. */
export function contactForceOn(body: Touchable, payload: Touchable | undefined, contacts: Float32Array, out: Vector3): number {
  out.set(0, 0, 0);
  let points = 0;
  for (let k = 0; k + CONTACT_FLOATS <= contacts.length; k += CONTACT_FLOATS) {
    const [x, y, z, fx, fy, fz] = [0, 1, 2, 3, 4, 5].map((i) => contacts[k + i] ?? NaN) as [number, number, number, number, number, number];
    if (!Number.isFinite(x + y + z + fx + fy + fz) || !touches(body, x, y, z)) continue;
    const onPayload = payload !== undefined && touches(payload, x, y, z);
    const received = body.group === "payload" || (body.group === "vehicle" && !onPayload);
    out.x += received ? fx : -fx;
    out.y += received ? fy : -fy;
    out.z += received ? fz : -fz;
    points += 1;
  }
  return points;
}
