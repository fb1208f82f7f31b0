// History of telemetry rows. Every column is stored twice, one capacity apart, so that any stretch of the newest
// `capacity` rows is one contiguous view and reading never copies.

export class Ring {
  private readonly stamps: Float64Array;
  private readonly columns: Float32Array[];
  private next = 0;
  private count = 0;

  constructor(
    readonly capacity: number,
    readonly width: number,
  ) {
    this.stamps = new Float64Array(2 * capacity);
    this.columns = Array.from({ length: width }, () => new Float32Array(2 * capacity));
  }

  get length(): number {
    return this.count;
  }

  /** Stamp of the newest row; NaN while empty. */
  get lastStamp(): number {
    return this.count === 0 ? NaN : (this.stamps[this.next + this.capacity - 1] ?? NaN);
  }

  /** Appends the row that starts at `offset` of `values`. */
  push(stamp: number, values: ArrayLike<number>, offset: number): void {
    this.write(stamp, (column) => values[offset + column] ?? NaN);
  }

  /** Appends a row of NaN: rows are missing from here on. */
  pushGap(stamp: number): void {
    this.write(stamp, () => NaN);
  }

  clear(): void {
    this.next = 0;
    this.count = 0;
  }

  /** Stamps of all rows held, oldest first; a view that stays right until the next write. */
  stampView(): Float64Array {
    const [start, end] = this.bounds();
    return this.stamps.subarray(start, end);
  }

  /** Values of one column, parallel to `stampView`. */
  columnView(column: number): Float32Array {
    const [start, end] = this.bounds();
    return (this.columns[column] ?? new Float32Array(0)).subarray(start, end);
  }

  private bounds(): [number, number] {
    const end = this.next + this.capacity;
    return [end - this.count, end];
  }

  private write(stamp: number, value: (column: number) => number): void {
    const at = this.next;
    this.stamps[at] = stamp;
    this.stamps[at + this.capacity] = stamp;
    for (let column = 0; column < this.width; column += 1) {
      const data = this.columns[column];
      if (data === undefined) continue;
      const sample = value(column);
      data[at] = sample;
      data[at + this.capacity] = sample;
    }
    this.next = (at + 1) % this.capacity;
    this.count = Math.min(this.count + 1, this.capacity);
  }
}

/** Index of the first stamp that is not before `stamp`. */
export function lowerBound(stamps: Float64Array, stamp: number): number {
  let low = 0;
  let high = stamps.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((stamps[middle] ?? Infinity) < stamp) low = middle + 1;
    else high = middle;
  }
  return low;
}
