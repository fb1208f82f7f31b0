// The playhead of the page and the shared time axis of all charts: the stretch of time that they show, and their cursor. Both follow the
// flight, or stand in its past while the flight goes on and its history grows. The playhead of a mirrored recording is the server's: this
// page asks for a move, and the flight then comes to the new moment.

/** A stretch of time: begin and end, s. */
export type Span = [number, number];

/** The times of the flight that the view needs. */
export interface Clock {
  /** Time of the newest tick, s. */
  now(): number;
  /** Time of the oldest tick in the history, s. */
  oldest(): number;
}

/** Length of the shortest stretch, s; a shorter one would show noise only. */
const SHORTEST_S = 0.05;
/** When the cursor leaves the stretch, the stretch follows until this part of it lies beyond the cursor. */
const MARGIN = 0.1;

export class View {
  /** Length of the stretch that follows the flight, s. */
  windowS = 20;
  /** Time by which a forecast reaches beyond the newest tick, s. */
  leadS = 0;
  /** Time of the playhead in the past, s; null while it follows the flight. */
  pinned: number | null = null;
  /** Moves the playhead of a mirrored recording to a time, s; null if the playhead is this page's own. */
  remote: ((time: number) => void) | null = null;
  /** Position of the pointer as a part of the width. */
  pointer: number | null = null;
  /** Begin and end of the range of the statistics, s. */
  range: { from: number | null; to: number | null } = { from: null, to: null };
  /** Times of the operator's marks, s. */
  markers: number[] = [];
  /** Number that grows with every change of the view. */
  version = 0;
  private held: Span | null = null;
  /** The view before the zoom, to which `unzoom` returns; null without a zoom. */
  private behind: { held: Span | null } | null = null;

  constructor(private readonly clock: Clock) {}

  get inspecting(): boolean {
    return this.held !== null;
  }

  /** Time of the newest tick, s. */
  newest(): number {
    return this.clock.now();
  }

  /** Time of the oldest tick of the history, s. */
  oldest(): number {
    return this.clock.oldest();
  }

  get zoomed(): boolean {
    return this.behind !== null;
  }

  span(): Span {
    if (this.held !== null) return this.held;
    const from = Math.max(0, this.clock.now() + this.leadS - this.windowS);
    return [from, from + this.windowS];
  }

  /** Time at the cursor, s: at the pointer while it is over the charts, else where the operator put it; null without a cursor. */
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

  /** Stops following the flight, and puts the cursor on the newest tick. */
  hold(): void {
    if (this.held !== null) return;
    this.held = this.span();
    if (this.remote === null) this.pinned = this.clock.now();
    this.version += 1;
  }

  /** Follows the flight again. */
  live(): void {
    this.held = null;
    this.behind = null;
    this.pinned = null;
    this.version += 1;
  }

  /** Stops following the flight, and shows the stretch between two times. */
  zoom(a: number, b: number): void {
    const [from, to] = [Math.min(a, b), Math.max(a, b)];
    const half = Math.max(SHORTEST_S, to - from) / 2;
    const middle = (from + to) / 2;
    this.behind ??= { held: this.held };
    this.held = [middle - half, middle + half];
    if (this.remote === null && (this.pinned === null || this.pinned < from || this.pinned > to)) this.pinned = Math.min(middle, this.clock.now());
    this.version += 1;
  }

  /** Leaves the zoom, or without a zoom follows the flight again. Returns false if there was nothing to leave. */
  back(): boolean {
    if (this.behind !== null) this.unzoom();
    else if (this.held !== null) this.live();
    else return false;
    return true;
  }

  /** Shows the stretch from before the zoom again. */
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

  /** Multiplies the length of the stretch by `factor`; the time at the part `at` of the width stays in place. */
  scale(factor: number, at: number): void {
    const [from, to] = this.span();
    const length = Math.max(SHORTEST_S, (to - from) * factor);
    const middle = from + at * (to - from);
    this.zoom(middle - at * length, middle + (1 - at) * length);
  }

  /** Puts the playhead on `time`, in the middle of the stretch. */
  show(time: number): void {
    if (this.remote !== null) return this.remote(time);
    this.held = this.around(time, this.held === null || this.zoomed ? this.windowS : this.held[1] - this.held[0]);
    this.behind = null;
    this.pinned = time;
    this.pointer = null;
    this.version += 1;
  }

  /** Moves the playhead; the stretch follows when the playhead leaves it. */
  moveCursor(time: number): void {
    if (this.remote !== null) return this.remote(time);
    this.hold();
    this.pinned = Math.min(this.clock.now(), Math.max(this.clock.oldest(), time));
    this.pointer = null;
    const [from, to] = this.span();
    const margin = MARGIN * (to - from);
    if (this.pinned >= from && this.pinned <= to) return;
    this.held = this.shifted(this.pinned < from ? this.pinned - margin - from : this.pinned + margin - to);
    this.version += 1;
  }

  /** Puts a mark on `time`, or removes a mark within `reach` seconds. */
  toggleMarker(time: number, reach: number): void {
    const near = this.markers.find((marker) => Math.abs(marker - time) <= reach);
    this.markers = near === undefined ? [...this.markers, time].sort((a, b) => a - b) : this.markers.filter((marker) => marker !== near);
    this.version += 1;
  }

  /** Sets one end of the range. If the ends are then in the wrong order, the other end is removed. */
  setRange(end: "from" | "to", time: number): void {
    const range = { ...this.range, [end]: time };
    if (range.from !== null && range.to !== null && range.from > range.to) range[end === "from" ? "to" : "from"] = null;
    this.range = range;
    this.version += 1;
  }

  /** The range, s; null unless both of its ends are set. */
  marked(): { from: number; to: number } | null {
    const { from, to } = this.range;
    return from === null || to === null ? null : { from, to };
  }

  clearRange(): void {
    this.range = { from: null, to: null };
    this.version += 1;
  }

  /** Follows a flight again after a new start. The marks and the range stay only at another moment of the same recording. */
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

  /** `span`, moved so that it does not begin before the oldest tick or end after the newest one, as far as possible. */
  private inside([from, to]: Span): Span {
    const length = to - from;
    const latest = Math.max(this.clock.oldest(), this.clock.now() + this.leadS - length);
    const start = Math.max(0, this.clock.oldest() - MARGIN * length, Math.min(from, latest));
    return [start, start + length];
  }
}
