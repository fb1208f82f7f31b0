// Where a camera has to stand so that given points fill its picture.
import { Box3, type Object3D, type PerspectiveCamera, Vector3 } from "three";

/** Share of the half picture that the points may fill. */
const FILL = 0.92;
/** A vehicle whose middle is farther out than this share of the half picture is about to leave it. */
const RIM = 0.96;
/** Larger things (a floor, walls) do not count, m. */
const FIT_WITHIN_M = 5;
/** The vehicle climbs and sways around what it works on by about this much, m. */
const ROOM_ABOVE_M = 0.4;
const ROOM_ASIDE_M = 0.35;
/** Scenes smaller than this are shown with some surroundings, m. */
const SMALLEST_HALF_M = 0.5;

/** Corners of the boxes around all children of `root` that are not floor or wall, with room to fly. */
export function rimOf(root: Object3D, vehicle: Vector3): Vector3[] {
  root.updateMatrixWorld(true);
  const points: Vector3[] = [];
  const whole = new Box3().setFromCenterAndSize(vehicle, new Vector3(1, 1, 1).multiplyScalar(2 * SMALLEST_HALF_M));
  for (const child of root.children) {
    const own = new Box3().setFromObject(child);
    const size = own.getSize(new Vector3());
    if (!child.visible || own.isEmpty() || Math.max(size.x, size.y, size.z) >= FIT_WITHIN_M) continue;
    points.push(...corners(own));
    whole.union(own);
  }
  // The vehicle may be above any of it, but no farther aside than it is wide.
  const { min, max } = whole;
  const middle = (min.y + max.y) / 2;
  const top = vehicle.z + ROOM_ABOVE_M;
  const way = new Box3(new Vector3(min.x, middle - ROOM_ASIDE_M, 0), new Vector3(max.x, middle + ROOM_ASIDE_M, top));
  return [...points, ...corners(way)];
}

/** The position nearest to the points, in `direction` from them, from which all are in the picture. */
export function fitView(points: Vector3[], direction: Vector3, { fov, aspect }: { fov: number; aspect: number }): { target: Vector3; position: Vector3 } {
  const tanY = Math.tan((fov * Math.PI) / 360) * FILL;
  const tanX = tanY * aspect;
  const back = direction.clone().normalize();
  const right = new Vector3(0, 0, 1).cross(back).normalize();
  const up = back.clone().cross(right);
  // A point at (a, b) from the axis and c towards the camera is inside while |a - x| <= tanX (d - c), and so for b: each
  // side of the picture is a plane, and the two opposite planes that touch the points give centre and distance.
  const sideways = span(points, right, back, tanX);
  const upwards = span(points, up, back, tanY);
  const distance = Math.max(sideways.distance, upwards.distance);
  const position = new Vector3().addScaledVector(right, sideways.middle).addScaledVector(up, upwards.middle).addScaledVector(back, distance);
  const depth = points.reduce((sum, point) => sum + point.dot(back), 0) / Math.max(1, points.length);
  return { target: position.clone().addScaledVector(back, Math.min(depth, distance - 0.5) - distance), position };
}

/** Whether `point` is well inside the picture. */
export function isInView(camera: PerspectiveCamera, point: Vector3): boolean {
  camera.updateMatrixWorld();
  const { x, y, z } = point.clone().project(camera);
  return Math.abs(x) < RIM && Math.abs(y) < RIM && z < 1;
}

function span(points: Vector3[], across: Vector3, back: Vector3, tan: number): { middle: number; distance: number } {
  let high = -Infinity;
  let low = Infinity;
  for (const point of points) {
    const a = point.dot(across);
    const c = point.dot(back);
    high = Math.max(high, a + tan * c);
    low = Math.min(low, a - tan * c);
  }
  return { middle: (high + low) / 2, distance: (high - low) / (2 * tan) };
}

function corners({ min, max }: Box3): Vector3[] {
  return [min.x, max.x].flatMap((x) => [min.y, max.y].flatMap((y) => [min.z, max.z].map((z) => new Vector3(x, y, z))));
}
