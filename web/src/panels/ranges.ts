// Ranges of what an operator may set in the world, as the server's registry of quantities has them.
import type { Hello, QuantityInfo } from "../protocol";

export type Range = Pick<QuantityInfo, "min" | "max" | "step">;

/** The quantity of this name; null before the server has said what there is. */
export function rangeOf(hello: Hello | null, name: string): QuantityInfo | null {
  return hello?.quantities.find((quantity) => quantity.name === name) ?? null;
}

/** The same range in a unit of which one of the quantity's has `per`. */
export function scaled({ min, max, step }: Range, per: number): Range {
  const tidy = (value: number): number => Number((value * per).toPrecision(12));
  return { min: tidy(min), max: tidy(max), step: tidy(step) };
}

/** Only what is not below zero, for the magnitude of a vector whose axes have this range. */
export function magnitude({ min, max, step }: Range): Range {
  return { min: Math.max(0, min), max, step };
}
