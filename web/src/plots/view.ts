// The one clock of all charts: which stretch of time they show, and where the cursor stands. Either the stretch follows
// the flight, or it is held for inspection while the flight and the recording of its history go on.

/** From, to, s. */
export type Span = [number, number];

/** What the view has to know of the flight. */
export interface Clock {
  /** Time of the newest tick, s. */
  now(): number;
  /** Time of the oldest tick held, s. */
  oldest(): number;
}

/** A stretch shorter than this shows nothing but noise, s. */
const SHORTEST_S = 0.05;
/** Part of the stretch that is kept free on either side when the cursor leaves it. */
const MARGIN = 0.1;

export class View {
  /** Length of the stretch that follows the flight, s. */
  windowS = 20;
  /** How far a forecast reaches beyond the newest tick, s. */
  leadS = 0;
  /** Where the cursor was put while inspecting, s. */
  pinned: number | null = null;
  /** Where the pointer stands, as a part of the width. */
  pointer: number | null = null;
  /** In and out point of the statistics, s. */
  range: { from: number | null; to: number | null } = { from: null, to: null };
  /** Marks of the operator, s. */
  markers: number[] = [];
  /** Goes up with every change of what is shown. */
  version = 0;
  private held: Span | null = null;
  /** What a zoom left behind: null while not zoomed. */
  private behind: { held: Span | null } | null = null;

  constructor(private readonly clock: Clock) {}

  get inspecting(): boolean {
    return this.held !== null;
  }

  get zoomed(): boolean {
    return this.behind !== null;
  }

  span(): Span {
    if (this.held !== null) return this.held;
    const from = Math.max(0, this.clock.now() + this.leadS - this.windowS);
    return [from, from + this.windowS];
  }

  /** Time under the cursor: the pointer's while it is over the charts, else the one put; null for none. */
  cursor([from, to]: Span = this.span()): number | null {
    if (this.pointer === null) return this.held === null ? null : this.pinned;
    return from + this.pointer * (to - from);
  }

  setWindow(seconds: number): void {
    this.windowS = seconds;
    if (this.held !== null) {
      const middle = this.pinned ?? (this.held[0] + this.held[1]) / 2;
      this.held = this.around(middle, seconds);
      this.behind = null;
    }
    this.version += 1;
  }

  /** Holds what is shown; the cursor goes to the newest tick. */
  hold(): void {
    if (this.held !== null) return;
    this.held = this.span();
    this.pinned = this.clock.now();
    this.version += 1;
  }

  /** Follows the flight again. */
  live(): void {
    this.held = null;
    this.behind = null;
    this.pinned = null;
    this.version += 1;
  }

  /** Shows the stretch between two times, held. */
  zoom(a: number, b: number): void {
    const [from, to] = [Math.min(a, b), Math.max(a, b)];
    const half = Math.max(SHORTEST_S, to - from) / 2;
    const middle = (from + to) / 2;
    this.behind ??= { held: this.held };
    this.held = [middle - half, middle + half];
    if (this.pinned === null || this.pinned < from || this.pinned > to) this.pinned = Math.min(middle, this.clock.now());
    this.version += 1;
  }

  /** Takes one step back: out of the zoom, else to the flight. False if there was nothing to take back. */
  back(): boolean {
    if (this.behind !== null) this.unzoom();
    else if (this.held !== null) this.live();
    else return false;
    return true;
  }

  /** What was shown before the zoom. */
  unzoom(): void {
    if (this.behind === null) return;
    const { held } = this.behind;
    this.behind = null;
    if (held === null) return this.live();
    this.held = held;
    this.version += 1;
  }

  /** Moves the stretch by `seconds`, as far as there is history. */
  pan(seconds: number): void {
    this.hold();
    this.held = this.inside(this.shifted(seconds));
    this.version += 1;
  }

  /** Makes the stretch `factor` as long; the time at the part `at` of the width stays where it is. */
  scale(factor: number, at: number): void {
    const [from, to] = this.span();
    const length = Math.max(SHORTEST_S, (to - from) * factor);
    const middle = from + at * (to - from);
    this.zoom(middle - at * length, middle + (1 - at) * length);
  }

  /** Puts the cursor on `time` with the stretch around it. */
  show(time: number): void {
    this.held = this.around(time, this.held === null || this.zoomed ? this.windowS : this.held[1] - this.held[0]);
    this.behind = null;
    this.pinned = time;
    this.pointer = null;
    this.version += 1;
  }

  /** Moves the cursor; the stretch follows when the cursor leaves it. */
  moveCursor(time: number): void {
    this.hold();
    this.pinned = Math.min(this.clock.now(), Math.max(this.clock.oldest(), time));
    this.pointer = null;
    const [from, to] = this.span();
    const margin = MARGIN * (to - from);
    if (this.pinned >= from && this.pinned <= to) return;
    this.held = this.shifted(this.pinned < from ? this.pinned - margin - from : this.pinned + margin - to);
    this.version += 1;
  }

  /** Puts a mark on `time`, or takes the one within `reach` away. */
  toggleMarker(time: number, reach: number): void {
    const near = this.markers.find((marker) => Math.abs(marker - time) <= reach);
    this.markers = near === undefined ? [...this.markers, time].sort((a, b) => a - b) : this.markers.filter((marker) => marker !== near);
    this.version += 1;
  }

  /** Sets one end of the range; an end on the wrong side of the other takes that one away. */
  setRange(end: "from" | "to", time: number): void {
    const range = { ...this.range, [end]: time };
    if (range.from !== null && range.to !== null && range.from > range.to) range[end === "from" ? "to" : "from"] = null;
    this.range = range;
    this.version += 1;
  }

  /** The range, if both of its ends are set. */
  marked(): { from: number; to: number } | null {
    const { from, to } = this.range;
    return from === null || to === null ? null : { from, to };
  }

  clearRange(): void {
    this.range = { from: null, to: null };
    this.version += 1;
  }

  /** Another flight: nothing of the old one is left. Another moment of the same recording: its marks stay. */
  clear(sameFlight = false): void {
    if (!sameFlight) {
      this.markers = [];
      this.clearRange();
    }
    this.live();
  }

  private shifted(seconds: number): Span {
    const [from, to] = this.span();
    return [from + seconds, to + seconds];
  }

  private around(time: number, length: number): Span {
    return this.inside([time - length / 2, time + length / 2]);
  }

  /** `span` moved so that it shows history, if it can: not before the oldest tick, not beyond the newest. */
  private inside([from, to]: Span): Span {
    const length = to - from;
    const latest = Math.max(this.clock.oldest(), this.clock.now() + this.leadS - length);
    const start = Math.max(0, this.clock.oldest() - MARGIN * length, Math.min(from, latest));
    return [start, start + length];
  }
}
