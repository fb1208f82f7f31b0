// The channels of the last minutes: one row per tick, found by the tick's number. A lost tick has a row of NaN, so a stretch of
// time is always a stretch of rows.
import { type Extremes, LEVEL_TICKS, Pyramid } from "./pyramid";

/**
 * Ticks kept: 10.9 minutes at 100 Hz. One channel takes 256 KiB and its pyramid 39 KiB; the 237 channels of a flight
 * with a forecast therefore take 68 MiB, whatever the length of the flight.
 */
export const HISTORY_TICKS = 65_536;
const LONGEST = LEVEL_TICKS[LEVEL_TICKS.length - 1] ?? 1;

export class History {
  private readonly columns: Float32Array[];
  private readonly pyramids: Pyramid[];
  private start = NaN;
  private newest = NaN;

  /** `capacity` is the number of rows: a power of two, at least twice the longest stretch of a pyramid. */
  constructor(
    readonly capacity: number,
    readonly width: number,
  ) {
    this.columns = Array.from({ length: width }, () => new Float32Array(capacity));
    this.pyramids = Array.from({ length: width }, () => new Pyramid(capacity));
  }

  /** Oldest tick in the history; NaN while it is empty. It moves by whole stretches of the pyramids, so that they stay valid. */
  get first(): number {
    const kept = Math.ceil((this.newest + 1 - this.capacity) / LONGEST) * LONGEST;
    return Math.max(this.start, kept);
  }

  /** Newest tick in the history; NaN while it is empty. */
  get last(): number {
    return this.newest;
  }

  /** Number of ticks in the history, lost ones included. */
  get length(): number {
    return Number.isNaN(this.newest) ? 0 : this.newest - this.first + 1;
  }

  holds(tick: number): boolean {
    return tick >= this.first && tick <= this.newest;
  }

  /** Appends the row of `tick` that starts at `offset` of `values`; ticks between the newest and `tick` are lost. */
  push(tick: number, values: ArrayLike<number>, offset: number): void {
    if (tick - this.newest > this.capacity) this.clear();
    const fresh = Number.isNaN(this.newest);
    if (fresh) this.start = tick;
    else for (let lost = this.newest + 1; lost < tick; lost += 1) this.write(lost, null, 0, false);
    this.write(tick, values, offset, fresh);
  }

  clear(): void {
    this.start = NaN;
    this.newest = NaN;
  }

  /** Value of a column; NaN if it is unknown, or if the tick is not in the history. */
  at(column: number, tick: number): number {
    return this.holds(tick) ? (this.columns[column]?.[tick & (this.capacity - 1)] ?? NaN) : NaN;
  }

  /** Feeds the ticks `from` up to, not including, `to` of a column to `into`; all of them must be in the history. */
  scan(column: number, from: number, to: number, into: Extremes): void {
    const data = this.columns[column];
    if (data === undefined) return;
    const mask = this.capacity - 1;
    for (let tick = from; tick < to; tick += 1) into.add(data[tick & mask] ?? NaN);
  }

  /** Does as `scan` from the stretches of a pyramid's level; it may take in up to one stretch more at either end. */
  scanLevel(column: number, level: number, from: number, to: number, into: Extremes): void {
    const ticks = LEVEL_TICKS[level] ?? 1;
    for (let tick = Math.floor(from / ticks) * ticks; tick < to; tick += ticks) this.pyramids[column]?.read(level, tick, into);
  }

  private write(tick: number, values: ArrayLike<number> | null, offset: number, fresh: boolean): void {
    const at = tick & (this.capacity - 1);
    for (let column = 0; column < this.width; column += 1) {
      const data = this.columns[column];
      if (data === undefined) continue;
      data[at] = values?.[offset + column] ?? NaN;
      this.pyramids[column]?.add(tick, data[at] ?? NaN, fresh);
    }
    this.newest = tick;
  }
}
