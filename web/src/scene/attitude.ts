// Roll, pitch and yaw in degrees: ZYX Euler angles, as everywhere in the project.

const DEG = 180 / Math.PI;

/** Roll, pitch and yaw of a world-from-body quaternion `[w x y z]`, degrees. */
export function rollPitchYawDeg([w, x, y, z]: readonly [number, number, number, number]): [number, number, number] {
  const roll = Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y));
  const pitch = Math.asin(Math.min(1, Math.max(-1, 2 * (w * y - z * x))));
  const yaw = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
  return [roll * DEG, pitch * DEG, yaw * DEG];
}
