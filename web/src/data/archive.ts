// Keeps the rows of a mirrored recording that this page has received, by tick. After a jump the charts show the rows before the
// target from here, and not only the few seconds that the server sends before the target.
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

  /** Forgets all rows. */
  clear(): void {
    this.ticks.fill(-1);
  }

  /** Calls `into` for each row of the unbroken run of kept rows that ends just before `tick`: oldest first, at most `most` rows. */
  before(tick: number, most: number, into: (tick: number, values: Float32Array, offset: number) => void): void {
    let from = tick;
    while (from > 0 && tick - from < most && this.ticks[(from - 1) % this.capacity] === from - 1) from -= 1;
    for (let known = from; known < tick; known += 1) into(known, this.rows, (known % this.capacity) * this.width);
  }
}
