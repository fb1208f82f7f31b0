// Poses as telemetry has them, and values between two of them.

/** Numbers of a pose: x y z (m), then the quaternion w x y z. */
export const POSE_FLOATS = 7;

/** Interpolates the pose at the share `part` between `from` and `to`: the position along the line, the attitude by slerp. */
export function blendPose(out: Float32Array, from: Float32Array, to: Float32Array, offset: number, part: number): void {
  for (let i = offset; i < offset + 3; i += 1) out[i] = mixed(at(from, i), at(to, i), part);
  const q = offset + 3;
  const dot = at(from, q) * at(to, q) + at(from, q + 1) * at(to, q + 1) + at(from, q + 2) * at(to, q + 2) + at(from, q + 3) * at(to, q + 3);
  let [a, b] = [1 - part, part];
  const angle = Math.acos(Math.min(1, Math.abs(dot)));
  if (angle > 1e-4) {
    a = Math.sin((1 - part) * angle) / Math.sin(angle);
    b = Math.sin(part * angle) / Math.sin(angle);
  }
  // Two quaternions of opposite sign are the same attitude; this sign gives the shorter turn.
  if (dot < 0) b = -b;
  for (let i = q; i < q + 4; i += 1) {
    const value = a * at(from, i) + b * at(to, i);
    out[i] = Number.isNaN(value) ? at(to, i) : value;
  }
}

/** Interpolates a number; if either end is unknown, it is the newest value. */
export function mixed(from: number, to: number, part: number): number {
  const value = from + part * (to - from);
  return Number.isNaN(value) ? to : value;
}

/** A value of the list; NaN beyond its end. */
export function at(values: Float32Array, index: number): number {
  return values[index] ?? NaN;
}
