// Converts a slider's position (0..1) to a gain and back. Ranges of more than three decades are logarithmic, so that a slider from
// 0.05 to 1000000 can still be set to 2.

const LOGARITHMIC_RATIO = 1000;
const FINEST_SLIDER = 2000;

export interface Range {
  min: number;
  max: number;
  step: number;
}

export function isLogarithmic({ min, max }: Range): boolean {
  return min > 0 && max / min > LOGARITHMIC_RATIO;
}

export function positionOf(value: number, range: Range): number {
  const { min, max } = range;
  const position = isLogarithmic(range) ? Math.log(value / min) / Math.log(max / min) : (value - min) / (max - min);
  return Math.min(1, Math.max(0, position));
}

export function valueAt(position: number, range: Range): number {
  const { min, max, step } = range;
  if (isLogarithmic(range)) return clamp(roundSignificant(min * (max / min) ** position, 3), range);
  return clamp(roundTo(min + position * (max - min), step, min), range);
}

/** Number of positions of a slider: one per step of the gain if the slider is fine enough, so that an arrow key moves one step. */
export function sliderSteps(range: Range): number {
  if (isLogarithmic(range) || range.step <= 0) return FINEST_SLIDER;
  return Math.max(1, Math.min(FINEST_SLIDER, Math.round((range.max - range.min) / range.step)));
}

/** The value with as many decimals as it needs, without rounding noise at the end. */
export function formatGain(value: number): string {
  return String(roundSignificant(value, 6));
}

function roundTo(value: number, step: number, origin: number): number {
  if (step <= 0) return value;
  return roundSignificant(origin + Math.round((value - origin) / step) * step, 12);
}

function roundSignificant(value: number, digits: number): number {
  return Number(value.toPrecision(digits));
}

function clamp(value: number, { min, max }: Range): number {
  return Math.min(max, Math.max(min, value));
}
