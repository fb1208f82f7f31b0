// What a mirrored recording has shown so far, by tick: after a jump the charts begin with what was drawn before, and not with the
// run-up of the server alone.
import { HISTORY_TICKS } from "./history";

export class Archive {
  private readonly rows: Float32Array;
  /** Tick of each slot; -1 while it is empty. */
  private readonly ticks: Int32Array;

  /** `width` numbers per row; `capacity` rows are kept. */
  constructor(
    readonly width: number,
    readonly capacity = HISTORY_TICKS,
  ) {
    this.rows = new Float32Array(capacity * width);
    this.ticks = new Int32Array(capacity).fill(-1);
  }

  /** Keeps the row of `tick` that starts at `offset` of `values`. */
  put(tick: number, values: Float32Array, offset: number): void {
    const slot = tick % this.capacity;
    this.rows.set(values.subarray(offset, offset + this.width), slot * this.width);
    this.ticks[slot] = tick;
  }

  /** Nothing is known any more. */
  clear(): void {
    this.ticks.fill(-1);
  }

  /** Gives every row that leads up to `tick` without a hole to `into`, oldest first, at most `most` of them. */
  before(tick: number, most: number, into: (tick: number, values: Float32Array, offset: number) => void): void {
    let from = tick;
    while (from > 0 && tick - from < most && this.ticks[(from - 1) % this.capacity] === from - 1) from -= 1;
    for (let known = from; known < tick; known += 1) into(known, this.rows, (known % this.capacity) * this.width);
  }
}
