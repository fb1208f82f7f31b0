// Smallest and largest value of one channel over stretches of 16 and of 256 ticks, in their order in time. A long window is drawn
// from a few thousand such pairs and not from every tick. Each new value updates the pairs; they are never rebuilt.

/** Number of ticks of a stretch, by level. */
export const LEVEL_TICKS = [16, 256] as const;

/** Smallest and largest of the values fed in, and which of the two came first. A NaN is noted and otherwise ignored. */
export class Extremes {
  low = NaN;
  high = NaN;
  missing = false;
  private lowFirst = true;

  clear(): void {
    this.low = NaN;
    this.high = NaN;
    this.missing = false;
    this.lowFirst = true;
  }

  add(value: number): void {
    if (Number.isNaN(value)) {
      this.missing = true;
    } else if (Number.isNaN(this.low)) {
      this.low = value;
      this.high = value;
    } else if (value < this.low) {
      this.low = value;
      this.lowFirst = false;
    } else if (value > this.high) {
      this.high = value;
      this.lowFirst = true;
    }
  }

  /** Whether no value other than NaN was fed in. */
  get empty(): boolean {
    return Number.isNaN(this.low);
  }

  get first(): number {
    return this.lowFirst ? this.low : this.high;
  }

  get second(): number {
    return this.lowFirst ? this.high : this.low;
  }
}

export class Pyramid {
  private readonly pairs: Float32Array[];
  private readonly missing: Uint8Array[];

  /** `capacity` is the number of ticks of the history, a multiple of the longest stretch. */
  constructor(capacity: number) {
    this.pairs = LEVEL_TICKS.map((ticks) => new Float32Array((2 * capacity) / ticks));
    this.missing = LEVEL_TICKS.map((ticks) => new Uint8Array(capacity / ticks));
  }

  /** Takes the value of `tick`; ticks come one after the other. `fresh` tells that the history starts anew at `tick`. */
  add(tick: number, value: number, fresh: boolean): void {
    for (let level = 0; level < LEVEL_TICKS.length; level += 1) {
      const ticks = LEVEL_TICKS[level] ?? 1;
      const pairs = this.pairs[level];
      const missing = this.missing[level];
      if (pairs === undefined || missing === undefined) continue;
      const slot = Math.floor(tick / ticks) % missing.length;
      if (fresh || tick % ticks === 0) {
        pairs[2 * slot] = NaN;
        pairs[2 * slot + 1] = NaN;
        missing[slot] = 0;
      }
      if (Number.isNaN(value)) missing[slot] = 1;
      else widen(pairs, 2 * slot, value);
    }
  }

  /** Feeds the stretch of `level` that contains `tick` to `into`. */
  read(level: number, tick: number, into: Extremes): void {
    const pairs = this.pairs[level];
    const missing = this.missing[level];
    if (pairs === undefined || missing === undefined) return;
    const slot = Math.floor(tick / (LEVEL_TICKS[level] ?? 1)) % missing.length;
    const first = pairs[2 * slot] ?? NaN;
    if (!Number.isNaN(first)) {
      into.add(first);
      into.add(pairs[2 * slot + 1] ?? NaN);
    }
    if (missing[slot] === 1) into.missing = true;
  }
}

/** Widens the pair at index `at` so that it includes a later `value`. */
function widen(pairs: Float32Array, at: number, value: number): void {
  const first = pairs[at] ?? NaN;
  const second = pairs[at + 1] ?? NaN;
  if (Number.isNaN(first)) {
    pairs[at] = value;
    pairs[at + 1] = value;
  } else if (value < Math.min(first, second)) {
    pairs[at] = Math.max(first, second);
    pairs[at + 1] = value;
  } else if (value > Math.max(first, second)) {
    pairs[at] = Math.min(first, second);
    pairs[at + 1] = value;
  }
}
