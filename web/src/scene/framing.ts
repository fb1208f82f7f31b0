// Computes the position of a camera from which given points fill the picture.
import { Box3, type Object3D, type PerspectiveCamera, Vector3 } from "three";

/** Share of the half picture that the points may fill. */
const FILL = 0.92;
/** A vehicle whose centre is farther out than this share of the half picture is about to leave the picture. */
const RIM = 0.96;
/** Larger bodies, such as a floor or a wall, are ignored, m. */
const FIT_WITHIN_M = 5;
/** Room for the flight above the vehicle and to its sides, m. */
const ROOM_ABOVE_M = 0.4;
const ROOM_ASIDE_M = 0.35;
/** Half size of the smallest region that is shown, m. */
const SMALLEST_HALF_M = 0.5;

/** Corners of the boxes around all children of `root` other than floor and walls, and of a box that leaves room for the flight. */
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
  // The vehicle may fly above all of these bodies, but it stays near their middle line.
  const { min, max } = whole;
  const middle = (min.y + max.y) / 2;
  const top = vehicle.z + ROOM_ABOVE_M;
  const way = new Box3(new Vector3(min.x, middle - ROOM_ASIDE_M, 0), new Vector3(max.x, middle + ROOM_ASIDE_M, top));
  return [...points, ...corners(way)];
}

/** The camera position nearest to the points, in `direction` from them, from which all points are in the picture; and its target. */
export function fitView(points: Vector3[], direction: Vector3, { fov, aspect }: { fov: number; aspect: number }): { target: Vector3; position: Vector3 } {
  const tanY = Math.tan((fov * Math.PI) / 360) * FILL;
  const tanX = tanY * aspect;
  const back = direction.clone().normalize();
  const right = new Vector3(0, 0, 1).cross(back).normalize();
  const up = back.clone().cross(right);
  // A point at (a, b) from the axis and c towards the camera is inside if |a - x| <= tanX (d - c), and likewise for b. Each side of
  // the picture is a plane. The two opposite planes that touch the points give the centre x and the distance d.
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
