// The content of the timeline at the foot: the phases, the marks by lane, and the innovation over its threshold.
import { Extremes, LEVEL_TICKS } from "../data/pyramid";
import type { Store } from "../data/store";
import type { Mark } from "../plots/clusters";
import { marksOf } from "../plots/frame";
import type { Span, View } from "../plots/view";

/** Lanes with marks, and the kinds of marks of each. A kind that stands in none is in the last lane. */
export const MARK_LANES = [
  { key: "adapter", label: "adapter", kinds: ["reset", "fault", "saturation", "gap"] },
  { key: "gains", label: "gains", kinds: ["gain", "marker"] },
  { key: "world", label: "world", kinds: ["disturbance", "grasp", "release", "retry", "verdict"] },
] as const;

export interface PhaseBlock {
  /** Begin and end, s. */
  span: Span;
  text: string;
}

export interface Lanes {
  /** Stretch of the whole timeline, s. */
  span: Span;
  phases: PhaseBlock[];
  /** Marks of each lane, oldest first. */
  marks: Mark[][];
  /** Largest innovation over δ in each column of pixels; NaN where it is unknown. */
  ribbon: number[];
}

/** The lanes of the stretch `span` on `width` px. */
export function lanesOf(store: Store, view: View, span: Span, width: number): Lanes {
  const [first, last] = [store.tickAt(span[0]) - 1, store.tickAt(span[1]) + 1];
  const marks = marksOf(store, view, first, last).filter(({ kind }) => kind !== "phase");
  return {
    span,
    phases: phasesOf(store, Math.min(span[1], Math.max(view.newest(), store.hello?.mirror?.duration_s ?? 0))),
    marks: MARK_LANES.map((_, lane) => marks.filter(({ kind }) => lane === laneOf(kind))),
    ribbon: ribbonOf(store, span, width),
  };
}

function laneOf(kind: string): number {
  const found = MARK_LANES.findIndex(({ kinds }) => (kinds as readonly string[]).includes(kind));
  return found < 0 ? MARK_LANES.length - 1 : found;
}

/** The phases of the flight up to `end`, s; of a mirrored recording those of the whole recording, if they are known. */
function phasesOf(store: Store, end: number): PhaseBlock[] {
  const whole = store.hello?.mirror?.phases ?? [];
  const begun = whole.length > 0 ? whole : store.events.filter(({ kind }) => kind === "phase");
  return begun.map(({ tick, text }, k) => {
    const next = begun[k + 1];
    return { span: [store.timeOf(tick), next === undefined ? end : store.timeOf(next.tick)], text };
  });
}

function ribbonOf(store: Store, [from, to]: Span, width: number): number[] {
  const { history } = store;
  const [mean, threshold] = [store.index("innovation_mean"), store.index("reset_threshold")];
  if (mean === undefined || threshold === undefined) return [];
  const found = new Extremes();
  const tickAt = (x: number): number => store.tickAt(from + (x / width) * (to - from));
  return Array.from({ length: Math.max(0, Math.floor(width)) }, (_, x) => {
    const [first, last] = [Math.max(history.first, tickAt(x)), Math.min(history.last, Math.max(tickAt(x + 1) - 1, tickAt(x)))];
    if (!(first <= last)) return NaN;
    found.clear();
    const ticks = LEVEL_TICKS[0];
    if (last - first >= ticks) history.scanLevel(mean, 0, first, last + 1, found);
    else history.scan(mean, first, last + 1, found);
    return found.high / history.at(threshold, last);
  });
}

/** Events and marks at which an operator can stop, oldest first: all but the changes of phases that follow each other at once. */
export function stopsOf(store: Store, view: View): number[] {
  const whole = (store.hello?.mirror?.phases ?? []).map(({ tick }) => store.timeOf(tick));
  const times = marksOf(store, view, 0, Infinity).map(({ time }) => time);
  return [...new Set([...whole, ...times])].sort((a, b) => a - b);
}
