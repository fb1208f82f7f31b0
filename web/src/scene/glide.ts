// Interpolates between telemetry frames. The shown poses glide to the newest frame within about one frame period, so that motion at
// 10 frames/s looks as smooth as at 100. Nothing is extrapolated: once the newest frame is reached, it is shown exactly. State: the
// values shown, at the start of the glide, and at its target; each is poses (x y z, w x y z) followed by single numbers.

import { at, blendPose, mixed, POSE_FLOATS } from "../data/pose";

/** Weight of a new interval in the mean frame period. */
const SMOOTHING = 0.1;
/** A longer interval is a pause and does not count as a frame period, ms. */
const LONGEST_INTERVAL_MS = 500;
/** A glide takes this many frame periods. It is more than one, so that a late frame does not find the motion at rest. */
const STRETCH = 1.15;
const SHORTEST_MS = 8;
const LONGEST_MS = 250;

export class Glide {
  readonly shown: Float32Array;
  /** Write the newest frame here, then call `arrived`. */
  readonly target: Float32Array;
  private readonly start: Float32Array;
  private periodMs = 20;
  private arrivedAt = -Infinity;
  private startAt = 0;
  private endAt = 0;
  private sampledAt = -Infinity;
  private settled = true;
  private known = false;

  constructor(
    private readonly poses: number,
    scalars: number,
  ) {
    const floats = poses * POSE_FLOATS + scalars;
    this.shown = new Float32Array(floats).fill(NaN);
    this.target = new Float32Array(floats).fill(NaN);
    this.start = new Float32Array(floats).fill(NaN);
  }

  /** Starts the glide to a new `target` at `now` (ms); with `exact` the target is shown at once. */
  arrived(now: number, exact: boolean): void {
    const interval = now - this.arrivedAt;
    this.arrivedAt = now;
    if (interval < LONGEST_INTERVAL_MS) this.periodMs += SMOOTHING * (interval - this.periodMs);
    if (exact || !this.known) return this.snap();
    this.start.set(this.shown);
    this.startAt = Math.max(this.sampledAt, now - LONGEST_MS);
    this.endAt = now + this.durationMs;
    this.settled = false;
  }

  /** Duration of the glide to a frame, ms. */
  get durationMs(): number {
    return Math.min(LONGEST_MS, Math.max(SHORTEST_MS, STRETCH * this.periodMs));
  }

  /** Shows the newest frame exactly. */
  snap(): void {
    this.shown.set(this.target);
    this.known = true;
    this.settled = true;
  }

  /** Forgets the shown values before another flight, so that nothing glides from one flight to the other. */
  forget(): void {
    this.known = false;
    this.settled = true;
  }

  /** Updates `shown` to the time `now`, ms; returns true if it changed. */
  sample(now: number): boolean {
    this.sampledAt = now;
    if (this.settled) return false;
    const share = (now - this.startAt) / (this.endAt - this.startAt);
    if (share >= 1) {
      this.snap();
      return true;
    }
    const part = Math.max(0, share);
    for (let pose = 0; pose < this.poses; pose += 1) blendPose(this.shown, this.start, this.target, pose * POSE_FLOATS, part);
    for (let i = this.poses * POSE_FLOATS; i < this.shown.length; i += 1) this.shown[i] = mixed(at(this.start, i), at(this.target, i), part);
    return true;
  }
}
