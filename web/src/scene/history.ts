// Keeps the last telemetry frames to compute speeds. Telemetry has no velocities of bodies, so they are computed from poses.
import { Quaternion } from "three";
import { POSE_FLOATS } from "../data/pose";

const FRAMES = 32;
/** Speeds are means over about this time, s. A shorter time gives noisy speeds, a longer one late speeds. */
const SPAN_S = 0.15;
/** Two frames that are closer together than this give no speed, s. */
const SHORTEST_S = 1e-4;

export interface Motion {
  /** Velocity in the world, m/s. */
  velocity: [number, number, number];
  /** Magnitude of the angular velocity, rad/s. */
  turning: number;
}

interface Frame {
  tSim: number;
  poses: Float32Array;
}

export class PoseHistory {
  private readonly frames: Frame[] = [];
  private readonly from = new Quaternion();
  private readonly to = new Quaternion();

  /** Adds a frame; `poses` is kept without a copy. */
  add(tSim: number, poses: Float32Array): void {
    if (tSim <= (this.frames.at(-1)?.tSim ?? -Infinity)) this.frames.length = 0;
    if (this.frames.length === FRAMES) this.frames.shift();
    this.frames.push({ tSim, poses });
  }

  clear(): void {
    this.frames.length = 0;
  }

  /** Mean motion of the moving body `index` up to the newest frame; NaN if there are too few frames. */
  motion(index: number): Motion {
    const unknown: Motion = { velocity: [NaN, NaN, NaN], turning: NaN };
    const newest = this.frames.at(-1);
    if (newest === undefined) return unknown;
    let oldest = newest;
    for (let i = this.frames.length - 2; i >= 0 && newest.tSim - oldest.tSim < SPAN_S; i -= 1) oldest = this.frames[i] ?? oldest;
    const dt = newest.tSim - oldest.tSim;
    if (dt < SHORTEST_S) return unknown;
    const k = index * POSE_FLOATS;
    const [a, b] = [oldest.poses, newest.poses];
    const rate = (i: number): number => ((b[k + i] ?? NaN) - (a[k + i] ?? NaN)) / dt;
    const turned = read(this.from, a, k).angleTo(read(this.to, b, k));
    return { velocity: [rate(0), rate(1), rate(2)], turning: turned / dt };
  }
}

function read(out: Quaternion, poses: Float32Array, k: number): Quaternion {
  return out.set(poses[k + 4] ?? NaN, poses[k + 5] ?? NaN, poses[k + 6] ?? NaN, poses[k + 3] ?? NaN);
}
