// Round times on the shared time axis, for the grid of every chart and the labels of the timeline.
import { niceStep } from "./range";
import type { Span } from "./view";

/** Round times within `span`, at least `apart` px apart on a plot of `width` px. */
export function clockSplits([from, to]: Span, width: number, apart: number): number[] {
  const step = niceStep(((to - from) * apart) / Math.max(apart, width));
  const splits: number[] = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to + 1e-9 * step; k += 1) splits.push(Number((k * step).toPrecision(12)));
  return splits;
}

/** A time in seconds, with as many decimals as it needs. */
export function clockText(time: number): string {
  return `${Number(time.toFixed(3))} s`.replace("-", "−");
}
