// The current values of one body, in the units that the card shows.
import { Matrix4, Vector3 } from "three";
import type { SceneGroup, StateInfo } from "../protocol";
import { rollPitchYawDeg } from "./attitude";
import type { Body } from "./bodies";
import { contactForceOn, type Touchable } from "./touching";
import type { World } from "./world";

export interface BodyReading {
  name: string;
  group: SceneGroup;
  /** Mass; null if the scene does not tell it. */
  massKg: number | null;
  /** Position in the world, m. */
  position: [number, number, number];
  /** Roll, pitch and yaw, degrees. */
  rollPitchYaw: [number, number, number];
  /** Velocity in the world, m/s. */
  velocity: [number, number, number];
  contactN: number;
  contactPoints: number;
  /** Distance from the reference; null for a body without a reference. */
  offReferenceM: number | null;
}

const force = new Vector3();

export function readingOf(world: World, body: Body, state: StateInfo | null): BodyReading {
  const { name, group, object, index } = body;
  const payload = world.bodies?.moving.find((other) => other.group === "payload");
  const contactPoints = contactForceOn(touchable(body), payload === undefined ? undefined : touchable(payload), world.contactsInSight, force);
  const { position: p, quaternion: q } = object;
  return {
    name,
    group,
    massKg: group === "payload" ? (state?.payload_kg ?? null) : null,
    position: [p.x, p.y, p.z],
    rollPitchYaw: rollPitchYawDeg([q.w, q.x, q.y, q.z]),
    velocity: index < 0 ? [0, 0, 0] : world.history.motion(index).velocity,
    contactN: force.length(),
    contactPoints,
    offReferenceM: body === world.bodies?.vehicle() ? world.bodies.offReference() : null,
  };
}

function touchable({ group, box, object }: Body): Touchable {
  object.updateWorldMatrix(true, false);
  return { group, box, worldInverse: new Matrix4().copy(object.matrixWorld).invert() };
}
