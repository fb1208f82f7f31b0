// Stable value ranges. A range grows at once when a value leaves it, and shrinks only when the values need less than a third of
// it, so an axis does not change with every redraw.
import type { Sample } from "../data/decimate";

export type Bounds = [number, number];

const SHRINK_BELOW = 0.33;
const PADDING = 0.08;
/** A logarithmic range keeps up to this many decades that no value needs, so that a value near a power of ten does not make it jump. */
const SPARE_DECADES = 1;

/** Smallest and largest value of `series`, or of its positive values if `positiveOnly`; null if there is none. */
export function boundsOf(series: Sample[][], positiveOnly: boolean): Bounds | null {
  let low = Infinity;
  let high = -Infinity;
  for (const values of series) {
    for (const value of values) {
      if (value === null || value === undefined || (positiveOnly && value <= 0)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return low <= high ? [low, high] : null;
}

/** A linear range for `bounds` on round numbers, at least `smallestSpan` wide. */
export function linearRange(previous: Bounds | null, bounds: Bounds | null, smallestSpan: number): Bounds {
  if (bounds === null) return previous ?? [0, smallestSpan];
  const [low, high] = bounds;
  if (previous !== null && previous[0] <= low && high <= previous[1]) {
    const needed = Math.max(high - low, smallestSpan);
    if (needed >= SHRINK_BELOW * (previous[1] - previous[0])) return previous;
  }
  const middle = (low + high) / 2;
  const half = Math.max((high - low) / 2, smallestSpan / 2) * (1 + PADDING);
  const step = niceStep(half / 4);
  return [Math.floor((middle - half) / step) * step, Math.ceil((middle + half) / step) * step];
}

/** A logarithmic range over whole decades. */
export function decadeRange(previous: Bounds | null, bounds: Bounds | null): Bounds {
  if (bounds === null) return previous ?? [1, 10];
  const low = Math.floor(Math.log10(bounds[0]) + 1e-9);
  const high = Math.max(low + 1, Math.ceil(Math.log10(bounds[1]) - 1e-9));
  if (previous !== null && previous[0] <= bounds[0] && bounds[1] <= previous[1]) {
    const spare = Math.round(Math.log10(previous[1] / previous[0])) - (high - low);
    if (spare <= SPARE_DECADES) return previous;
  }
  return [10 ** low, 10 ** high];
}

/** The smallest number of the series 1, 2, 5, 10, … that is not below `step`. */
export function niceStep(step: number): number {
  const decade = 10 ** Math.floor(Math.log10(step));
  const factor = [1, 2, 5, 10].find((f) => f * decade >= step * (1 - 1e-9)) ?? 10;
  return factor * decade;
}

/** A value in at most seven characters; a dash if it is unknown. */
export function formatValue(value: number | null | undefined): string {
  if (value === null || value === undefined || Number.isNaN(value)) return "—";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const size = Math.abs(value);
  const text = size !== 0 && (size >= 1e5 || size < 1e-3) ? value.toExponential(0) : fixed(value, size);
  return text.replace("-", "−").replace("e+", "e");
}

function fixed(value: number, size: number): string {
  if (size >= 1000) return value.toFixed(0);
  if (size >= 100) return value.toFixed(1);
  return size >= 10 ? value.toFixed(2) : value.toFixed(3);
}
