// Statistics of one channel over a stretch of ticks.
import type { History } from "./history";

export interface Statistics {
  /** Number of known values. */
  count: number;
  /** Number of ticks without a known value: lost ones, and those with NaN. */
  missing: number;
  min: number;
  mean: number;
  max: number;
  rms: number;
}

/** Statistics over the ticks `from` to `to`, both included, that are in the history; NaN if no value is known. */
export function statistics(history: History, column: number, from: number, to: number): Statistics {
  let [count, missing, sum, squares, min, max] = [0, 0, 0, 0, Infinity, -Infinity];
  const end = Math.min(to, history.last);
  for (let tick = Math.max(from, history.first); tick <= end; tick += 1) {
    const value = history.at(column, tick);
    if (Number.isNaN(value)) {
      missing += 1;
      continue;
    }
    count += 1;
    sum += value;
    squares += value * value;
    min = Math.min(min, value);
    max = Math.max(max, value);
  }
  if (count === 0) return { count, missing, min: NaN, mean: NaN, max: NaN, rms: NaN };
  return { count, missing, min, mean: sum / count, max, rms: Math.sqrt(squares / count) };
}
