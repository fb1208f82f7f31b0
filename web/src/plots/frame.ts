// The data of one round of drawing, taken at one moment. All charts of the column therefore show the same stretch, although they
// are drawn one after the other.
import { bucketTicks } from "../data/decimate";
import { spansAbove, touching, within } from "../data/spans";
import type { Store } from "../data/store";
import type { Mark } from "./clusters";
import type { Span, View } from "./view";

export interface Frame {
  /** Stretch shown, s. */
  span: Span;
  /** The first tick drawn, and the tick after the last one drawn. */
  ticks: [number, number];
  /** Newest tick at the moment of the round. */
  newest: number;
  bucket: number;
  zscore: boolean;
  /** Marks in the stretch, oldest first. */
  marks: Mark[];
  /** Times of covariance resets, s. */
  resets: number[];
  gaps: Span[];
  frozen: Span[];
  range: Span | null;
  markers: number[];
  /** Time at which the forecast begins, s; null if no forecast is shown. */
  now: number | null;
}

/** Takes the data of a round; `width` is the width of a plot, px. */
export function takeFrame(store: Store, view: View, width: number, zscore: boolean, unmarked: string[]): Frame {
  const span = view.span();
  const ticks: [number, number] = [store.tickAt(span[0]) - 1, store.tickAt(span[1]) + 2];
  const bucket = bucketTicks((span[1] - span[0]) / store.tickS, width / 2);
  const [first, last] = ticks;
  const seconds = ({ from, to }: { from: number; to: number }): Span => [store.timeOf(from - 1), store.timeOf(to)];
  const frozen = store.index("frozen");
  return {
    span,
    ticks,
    newest: store.history.last,
    bucket,
    zscore,
    marks: marksOf(store, view, first, last).filter(({ kind }) => !unmarked.includes(kind)),
    resets: unmarked.includes("reset") ? [] : within(store.resets, first, last).map(store.timeOf),
    gaps: touching(store.gaps, first, last).map(seconds),
    frozen: frozen === undefined ? [] : spansAbove(store.history, frozen, first, last, bucket).map(seconds),
    range: rangeOf(view),
    markers: view.markers.filter((time) => time >= span[0] && time <= span[1]),
    now: view.leadS > 0 ? store.timeOf(store.history.last) : null,
  };
}

/** The range of the statistics. An end that is not set is the end of the stretch shown; null if neither end is set. */
export function rangeOf(view: View): Span | null {
  const { from, to } = view.range;
  if (from === null && to === null) return null;
  const span = view.span();
  return [from ?? Math.min(span[0], to ?? span[0]), to ?? Math.max(span[1], from ?? span[1])];
}

/** Events, resets, lost ticks and the operator's marks between two ticks, oldest first. */
export function marksOf(store: Store, view: View, first: number, last: number): Mark[] {
  const inside = ({ tick }: { tick: number }): boolean => tick >= first && tick <= last;
  const told = store.events.filter(inside).map(({ tick, kind, text }) => ({ tick, kind, text, time: store.timeOf(tick) }));
  const toldResets = new Set(told.filter(({ kind }) => kind === "reset").map(({ tick }) => tick));
  const resets = within(store.resets, first, last)
    .filter((tick) => !toldResets.has(tick))
    .map((tick) => ({ tick, kind: "reset", text: "the covariance was reset", time: store.timeOf(tick) }));
  const gaps = touching(store.gaps, first, last).map(({ from, to }) => ({
    tick: from,
    kind: "gap",
    text: `${to - from + 1} ${to === from ? "tick was" : "ticks were"} lost on the way to this page`,
    time: store.timeOf(from),
  }));
  const own = view.markers.map((time, k) => ({ tick: store.tickAt(time), kind: "marker", text: `your mark ${k + 1}`, time })).filter(inside);
  return [...told, ...resets, ...gaps, ...own].sort((a, b) => a.time - b.time);
}
