// What is known about the flight: the newest hello, the history of channels, and the newest poses.
import type { Telemetry } from "../link/decode";
import type { ChannelInfo, EventInfo, Hello, StateInfo } from "../protocol";
import { Ring } from "./ring";

/** Ticks of history kept: 80 s at 100 Hz, a little more than the longest window. */
const HISTORY_TICKS = 8192;
const KEPT_EVENTS = 200;

export class Store {
  hello: Hello | null = null;
  state: StateInfo | null = null;
  ring = new Ring(1, 0);
  /** Newest telemetry frame of this flight. */
  newest: Telemetry | null = null;
  /** Newest tick; -1 before the first. */
  lastTick = -1;
  /** Ticks at which the covariance was reset, oldest first. */
  resets: number[] = [];
  events: EventInfo[] = [];
  private columns = new Map<string, number>();

  /** Starts over with what `hello` describes. */
  accept(hello: Hello): void {
    this.hello = hello;
    this.state = hello.state;
    this.columns = new Map(hello.channels.map((channel, index) => [channel.name, index]));
    this.ring = new Ring(HISTORY_TICKS, hello.channels.length);
    this.clear();
    this.events = hello.events.slice(-KEPT_EVENTS);
  }

  /** Forgets the flight so far, keeps its description. */
  clear(): void {
    this.ring.clear();
    this.newest = null;
    this.lastTick = -1;
    this.resets = [];
    this.events = [];
  }

  /** Adds a frame; false if it belongs to another description of the flight. */
  ingest(frame: Telemetry): boolean {
    if (this.hello === null || frame.schemaId !== this.hello.schema_id || frame.channelCount !== this.ring.width) return false;
    const last = frame.firstTick + frame.rows - 1;
    const another = frame.reset || (frame.rows > 0 && frame.firstTick <= this.lastTick);
    if (another) {
      this.ring.clear();
      this.resets = [];
    } else if (this.lastTick >= 0 && frame.firstTick > this.lastTick + 1) {
      this.ring.pushGap(this.lastTick + 1);
    }
    const reset = this.columns.get("reset");
    for (let row = 0; row < frame.rows; row += 1) {
      const offset = row * frame.channelCount;
      this.ring.push(frame.firstTick + row, frame.channels, offset);
      if (reset !== undefined && (frame.channels[offset + reset] ?? 0) > 0.5) this.resets.push(frame.firstTick + row);
    }
    if (this.resets.length > HISTORY_TICKS) this.resets.splice(0, this.resets.length - HISTORY_TICKS);
    if (frame.rows > 0) this.lastTick = last;
    this.newest = frame;
    return true;
  }

  addEvents(events: EventInfo[]): void {
    this.events = [...this.events, ...events].slice(-KEPT_EVENTS);
  }

  /** Simulated time at the end of `tick`, s. */
  timeOf = (tick: number): number => (tick + 1) * (this.hello?.tick_s ?? 0.01);

  /** What the task is doing, in plain words where an event gave them. */
  phaseText(): string {
    const said = this.events.filter(({ kind }) => kind === "phase").at(-1);
    return said?.text ?? this.state?.task_phase.replaceAll("_", " ") ?? "";
  }

  channel(name: string): ChannelInfo | undefined {
    const index = this.columns.get(name);
    return index === undefined ? undefined : this.hello?.channels[index];
  }

  column(name: string): Float32Array | undefined {
    const index = this.columns.get(name);
    return index === undefined ? undefined : this.ring.columnView(index);
  }

  /** Newest value of a channel; NaN when unknown. */
  latest(name: string): number {
    const view = this.column(name);
    return view?.[view.length - 1] ?? NaN;
  }

  /** Row names that channels speak of, in order of appearance. */
  rows(): string[] {
    const named = (this.hello?.channels ?? []).flatMap((channel) => (channel.row === null ? [] : [channel.row]));
    return [...new Set(named)];
  }
}
