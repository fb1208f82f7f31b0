// The text of the hand's close-up.
import type { Store } from "../data/store";

const MM_PER_M = 1000;

/** Opening and grip force of the fingers, if they are known. */
export function handReading(store: Pick<Store, "shown">): string {
  const opening = store.shown("opening_m");
  const grip = store.shown("grip_force_n");
  const parts = [
    ...(Number.isFinite(opening) ? [`open ${(opening * MM_PER_M).toFixed(0)} mm`] : []),
    ...(Number.isFinite(grip) ? [`grip ${grip.toFixed(1)} N`] : []),
  ];
  return parts.join(" · ");
}
