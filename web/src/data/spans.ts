// Stretches of ticks, for example those in which the adapter is frozen or which were lost.
import type { History } from "./history";
import { Extremes, LEVEL_TICKS } from "./pyramid";

/** A stretch of ticks, both ends included. */
export interface TickSpan {
  from: number;
  to: number;
}

const COARSE_FROM = 16 * (LEVEL_TICKS[0] ?? 1);

/** Stretches within `from`..`to` in which `column` is above one half; their ends are exact to `resolution` ticks. */
export function spansAbove(history: History, column: number, from: number, to: number, resolution: number): TickSpan[] {
  const spans: TickSpan[] = [];
  const extremes = new Extremes();
  const step = resolution >= COARSE_FROM ? (LEVEL_TICKS[0] ?? 1) : 1;
  const end = Math.min(to, history.last);
  const begin = Math.floor(Math.max(from, history.first) / step) * step;
  for (let tick = begin; tick <= end; tick += step) {
    extremes.clear();
    if (step === 1) history.scan(column, tick, tick + 1, extremes);
    else history.scanLevel(column, 0, tick, tick + step, extremes);
    if (extremes.empty || extremes.high <= 0.5) continue;
    const last = spans.at(-1);
    if (last !== undefined && last.to >= tick - 1) last.to = tick + step - 1;
    else spans.push({ from: tick, to: tick + step - 1 });
  }
  return spans;
}

/** The members of the ascending, disjoint `spans` that overlap `from`..`to`. */
export function touching(spans: TickSpan[], from: number, to: number): TickSpan[] {
  return spans.filter((span) => span.to >= from && span.from <= to);
}

export function covers(spans: TickSpan[], tick: number): boolean {
  return spans.some((span) => span.from <= tick && tick <= span.to);
}

/** The members of the ascending `ticks` that lie in `from`..`to`. */
export function within(ticks: number[], from: number, to: number): number[] {
  return ticks.slice(lowerBound(ticks, from), lowerBound(ticks, to + 1));
}

/** Index of the first of the ascending `ticks` that is not before `tick`. */
export function lowerBound(ticks: ArrayLike<number>, tick: number): number {
  let low = 0;
  let high = ticks.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((ticks[middle] ?? Infinity) < tick) low = middle + 1;
    else high = middle;
  }
  return low;
}
