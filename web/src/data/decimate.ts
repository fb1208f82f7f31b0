// Reduces a stretch of history to a few points per pixel before it is drawn. Buckets are aligned to the ticks, not to
// the window, so a line keeps its shape while it scrolls. Every bucket keeps its minimum and maximum, and a missing
// value (NaN) breaks the line instead of spoiling the bucket.
import type { History } from "./history";
import { Extremes, LEVEL_TICKS } from "./pyramid";

/** `null` breaks the line; `undefined` means that the series has no point here and its line goes on (uPlot's convention). */
export type Sample = number | null | undefined;

export interface Decimated {
  /** Time of each point, s. */
  x: number[];
  series: Sample[][];
}

/** How one column of the history is drawn. */
export interface Trace {
  column: number;
  /** Known part that is taken from the value before it is drawn. */
  less?: number;
  /** Factor by which the rest is multiplied. */
  scale: number;
}

/** Ticks per bucket, a power of two, so that `windowTicks` give at most `buckets` of them. */
export function bucketTicks(windowTicks: number, buckets: number): number {
  const needed = windowTicks / Math.max(1, buckets);
  const bucket = 2 ** Math.max(0, Math.ceil(Math.log2(needed)));
  // A bucket of two ticks has two points, its minimum and maximum, so it would save nothing.
  return bucket === 2 ? 1 : bucket;
}

/** Points of `traces` at the ticks `from` up to, not including, `to`, with `bucket` ticks per bucket. */
export function decimate(history: History, traces: Trace[], from: number, to: number, bucket: number, timeOf: (tick: number) => number): Decimated {
  const out: Decimated = { x: [], series: traces.map(() => []) };
  const begin = Math.floor(Math.max(from, history.first) / bucket) * bucket;
  const end = Math.min(to, history.last + 1);
  const found = traces.map(() => new Extremes());
  for (let start = begin; start < end; start += bucket) {
    if (bucket === 1) single(out, history, traces, start, timeOf);
    else several(out, history, traces, start, bucket, found, timeOf);
  }
  return out;
}

function single(out: Decimated, history: History, traces: Trace[], tick: number, timeOf: (tick: number) => number): void {
  out.x.push(timeOf(tick));
  traces.forEach(({ column, scale, less = 0 }, k) => {
    const value = history.at(column, tick);
    out.series[k]?.push(Number.isNaN(value) ? (history.holds(tick) ? null : undefined) : (value - less) * scale);
  });
}

function several(
  out: Decimated,
  history: History,
  traces: Trace[],
  start: number,
  bucket: number,
  found: Extremes[],
  timeOf: (tick: number) => number,
): void {
  traces.forEach((trace, k) => {
    const extremes = found[k];
    if (extremes !== undefined) gather(history, trace, start, bucket, extremes);
  });
  const broken = found.some(({ missing }) => missing);
  out.x.push(timeOf(start), timeOf(start + bucket / 2));
  if (broken) out.x.push(timeOf(start + bucket - 1));
  found.forEach((extremes, k) => {
    const { scale, less = 0 } = traces[k] ?? { scale: 1 };
    const nothing = extremes.missing ? null : undefined;
    const series = out.series[k];
    series?.push(extremes.empty ? nothing : (extremes.first - less) * scale, extremes.empty ? nothing : (extremes.second - less) * scale);
    if (broken) series?.push(nothing);
  });
}

function gather(history: History, { column }: Trace, start: number, bucket: number, into: Extremes): void {
  into.clear();
  const from = Math.max(start, history.first);
  const to = Math.min(start + bucket, history.last + 1);
  if (from >= to) return;
  const level = levelFor(bucket);
  if (level < 0) history.scan(column, from, to, into);
  else history.scanLevel(column, level, from, to, into);
}

/** Coarsest level of the pyramid whose stretches fit into a bucket; -1 if there is none. */
function levelFor(bucket: number): number {
  let level = -1;
  LEVEL_TICKS.forEach((ticks, index) => {
    if (ticks <= bucket) level = index;
  });
  return level;
}
