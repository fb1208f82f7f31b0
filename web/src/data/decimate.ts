// Reduces a stretch of history to a few points per pixel before it is drawn. Buckets are aligned to the stamps, not to
// the window, so a line keeps its shape while it scrolls. Every bucket keeps its minimum and maximum, and a missing
// value (NaN) breaks the line instead of spoiling the bucket.

/** `null` breaks the line; `undefined` is "no point of this series here", the line goes on (uPlot's convention). */
export type Sample = number | null | undefined;

export interface Decimated {
  x: number[];
  series: Sample[][];
}

interface Extremes {
  first: Sample;
  second: Sample;
  missing: boolean;
}

/** Ticks per bucket so that `windowTicks` give at most `buckets` of them. */
export function bucketTicks(windowTicks: number, buckets: number): number {
  return Math.max(1, Math.ceil(windowTicks / Math.max(1, buckets)));
}

/** Points of `columns` between the indices `from` and `to`, `ticksPerBucket` stamps to a bucket. */
export function decimate(
  stamps: Float64Array,
  columns: Float32Array[],
  from: number,
  to: number,
  ticksPerBucket: number,
  timeOf: (stamp: number) => number,
): Decimated {
  const out: Decimated = { x: [], series: columns.map(() => []) };
  let start = from;
  while (start < to) {
    const bucket = Math.floor((stamps[start] ?? 0) / ticksPerBucket);
    let end = start + 1;
    while (end < to && Math.floor((stamps[end] ?? 0) / ticksPerBucket) === bucket) end += 1;
    emit(out, stamps, columns, start, end, timeOf);
    start = end;
  }
  return out;
}

function emit(
  out: Decimated,
  stamps: Float64Array,
  columns: Float32Array[],
  start: number,
  end: number,
  timeOf: (stamp: number) => number,
): void {
  const time = (index: number): number => timeOf(stamps[index] ?? 0);
  if (end - start === 1) {
    out.x.push(time(start));
    columns.forEach((column, k) => out.series[k]?.push(orNull(column[start])));
    return;
  }
  const found = columns.map((column) => extremes(column, start, end));
  const broken = found.some((f) => f.missing);
  out.x.push(time(start), time(start + ((end - start) >> 1)));
  if (broken) out.x.push(time(end - 1));
  found.forEach((f, k) => {
    out.series[k]?.push(f.first, f.second);
    if (broken) out.series[k]?.push(f.missing ? null : undefined);
  });
  // Three points of a two-tick bucket would share a time stamp; uPlot wants ascending x.
  if (broken && end - start === 2) nudge(out.x);
}

function nudge(x: number[]): void {
  const last = x.length - 1;
  const before = x[last - 1] ?? 0;
  x[last] = before + 1e-6;
}

function extremes(column: Float32Array, start: number, end: number): Extremes {
  let low = -1;
  let high = -1;
  let missing = false;
  for (let i = start; i < end; i += 1) {
    const value = column[i] ?? NaN;
    if (Number.isNaN(value)) missing = true;
    else {
      if (low < 0 || value < (column[low] ?? 0)) low = i;
      if (high < 0 || value > (column[high] ?? 0)) high = i;
    }
  }
  if (low < 0) return { first: null, second: null, missing };
  return { first: column[Math.min(low, high)], second: column[Math.max(low, high)], missing };
}

function orNull(value: number | undefined): number | null {
  return value === undefined || Number.isNaN(value) ? null : value;
}
