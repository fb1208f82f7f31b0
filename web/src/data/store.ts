// The state of the flight as this page knows it: the newest hello, the history of the channels, and the newest poses.
import type { Telemetry } from "../link/decode";
import type { ChannelInfo, EventInfo, Hello, StateInfo } from "../protocol";
import { Archive } from "./archive";
import { atEffect } from "./gainEvents";
import { ForkRows } from "./forkRows";
import { History, HISTORY_TICKS } from "./history";
import { Pictures } from "./pictures";
import { covers, type TickSpan } from "./spans";
import { StateLog } from "./stateLog";

/** Length of the history before the first `hello`: the shortest that is possible. */
const NO_HISTORY_TICKS = 512;
const KEPT_EVENTS = 2000;
/** Most rows that the charts take from the archive after a jump: one minute. A longer window fills while the recording plays. */
const RECALLED_TICKS = 6000;

export class Store {
  hello: Hello | null = null;
  /** The tick at which the page stands in the past; null while it follows the newest tick. */
  playhead: number | null = null;
  /** Where the bodies were at the ticks of the history. */
  readonly pictures = new Pictures();
  /** Payload, wind and effects in force over the flight. */
  readonly states = new StateLog();
  private newestState: StateInfo | null = null;
  history = new History(NO_HISTORY_TICKS, 0);
  /** Newest telemetry frame of this flight. */
  newest: Telemetry | null = null;
  /** Newest tick; -1 before the first. */
  lastTick = -1;
  /** Ticks at which the covariance was reset, oldest first. */
  resets: number[] = [];
  /** Ticks that were lost on the way to this page, oldest first. */
  gaps: TickSpan[] = [];
  events: EventInfo[] = [];
  readonly forks = new ForkRows();
  private columns = new Map<string, number>();
  /** The archive of the mirrored recording; null for a simulated flight and for a stream. */
  private archive: Archive | null = null;
  private recording: string | null = null;

  /** Newest state of the flight. */
  get state(): StateInfo | null {
    return this.newestState;
  }

  set state(state: StateInfo | null) {
    this.newestState = state;
    if (state !== null) this.states.put(state);
  }

  /** Starts over with the flight that `hello` describes. */
  accept(hello: Hello): void {
    this.hello = hello;
    this.states.clear();
    this.state = hello.state;
    this.rememberRecording(hello);
    this.columns = new Map(hello.channels.map((channel, index) => [channel.name, index]));
    this.history = new History(HISTORY_TICKS, hello.channels.length);
    this.clear();
    this.events = hello.events.slice(-KEPT_EVENTS).map((event) => atEffect(event, hello.tick_s));
    this.forks.update(hello.forks);
  }

  /** Forgets the rows and events of the flight; keeps its description. */
  clear(): void {
    this.forgetRows();
    this.newest = null;
    this.lastTick = -1;
    this.events = [];
    this.playhead = null;
  }

  /** Adds a frame; returns false if the frame belongs to another description of the flight. */
  ingest(frame: Telemetry): boolean {
    if (this.hello === null || frame.schemaId !== this.hello.schema_id || frame.channelCount !== this.history.width) return false;
    const another = frame.reset || (frame.rows > 0 && frame.firstTick <= this.lastTick);
    if (another) this.forgetRows();
    else if (frame.rows > 0 && this.lastTick >= 0 && frame.firstTick > this.lastTick + 1) {
      this.gaps.push({ from: this.lastTick + 1, to: frame.firstTick - 1 });
    }
    if (frame.rows > 0 && this.history.length === 0) this.archive?.before(frame.firstTick, RECALLED_TICKS, this.push);
    for (let row = 0; row < frame.rows; row += 1) {
      const offset = row * frame.channelCount;
      this.push(frame.firstTick + row, frame.channels, offset);
      this.archive?.put(frame.firstTick + row, frame.channels, offset);
    }
    this.forgetMarks();
    if (frame.rows > 0) this.lastTick = frame.firstTick + frame.rows - 1;
    this.newest = frame;
    this.pictures.put(frame);
    return true;
  }

  /** Forgets the archive after a change of gains, because rows under the old gains do not lead up to the new ones. */
  forgetDrawn(): void {
    this.archive?.clear();
  }

  /** Adds events, and returns them with the ticks at which they took effect. */
  addEvents(events: EventInfo[]): EventInfo[] {
    const told = events.map((event) => atEffect(event, this.tickS));
    this.events = [...this.events, ...told].slice(-KEPT_EVENTS);
    return told;
  }

  /** Simulated time at the end of `tick`, s. */
  timeOf = (tick: number): number => (tick + 1) * this.tickS;

  /** Tick whose end is nearest to the time, s. */
  tickAt = (time: number): number => Math.round(time / this.tickS) - 1;

  /** Period of a tick, s. */
  get tickS(): number {
    return this.hello?.tick_s ?? 0.01;
  }

  /** Number of ticks by which the predictor looks ahead; 0 if it does not. */
  get horizonTicks(): number {
    return this.hello?.horizon_ticks ?? 0;
  }

  /** The tick that the whole page shows: the playhead, or the newest tick. */
  get shownTick(): number {
    return this.playhead ?? this.history.last;
  }

  /** The phase of the task at the shown tick, in plain words if an event gave them. */
  phaseText(): string {
    const said = this.events.filter(({ kind, tick }) => kind === "phase" && tick <= (this.playhead ?? Infinity)).at(-1);
    return said?.text ?? (this.playhead === null ? this.state?.task_phase.replaceAll("_", " ") : undefined) ?? "";
  }

  channel(name: string): ChannelInfo | undefined {
    const index = this.columns.get(name);
    return index === undefined ? undefined : this.hello?.channels[index];
  }

  /** Column of a channel in the history. */
  index(name: string): number | undefined {
    return this.columns.get(name);
  }

  /** Value of a channel; NaN if it is unknown, or if the tick is not in the history. */
  at(name: string, tick: number): number {
    const index = this.columns.get(name);
    return index === undefined ? NaN : this.history.at(index, tick);
  }

  /** Value of a channel without the known weight of the vehicle; NaN as `at`. */
  withoutWeight(name: string, tick: number): number {
    return this.at(name, tick) - (this.channel(name)?.weight ?? 0);
  }

  /** Value of a channel at the shown tick; NaN when unknown. */
  shown(name: string): number {
    return this.at(name, this.shownTick);
  }

  /** Every channel at `tick` as one row of telemetry; NaN where unknown. */
  row(tick: number): Float32Array {
    return Float32Array.from({ length: this.history.width }, (_, column) => this.history.at(column, tick));
  }

  lost(tick: number): boolean {
    return covers(this.gaps, tick);
  }

  /** Names of the coordinates to which channels belong, in order of appearance. */
  rows(): string[] {
    const named = (this.hello?.channels ?? []).flatMap((channel) => (channel.row === null ? [] : [channel.row]));
    return [...new Set(named)];
  }

  private push = (tick: number, values: Float32Array, offset: number): void => {
    this.history.push(tick, values, offset);
    const reset = this.columns.get("reset");
    if (reset !== undefined && (values[offset + reset] ?? 0) > 0.5) this.resets.push(tick);
  };

  /** Keeps the archive if `hello` describes the same recording again, as after a jump. A stream has no archive. */
  private rememberRecording({ mirror, channels }: Hello): void {
    const recording = mirror === null || mirror === undefined || mirror.live ? null : JSON.stringify([mirror, channels]);
    if (recording === this.recording) return;
    this.recording = recording;
    this.archive = recording === null ? null : new Archive(channels.length);
  }

  private forgetRows(): void {
    this.history.clear();
    this.pictures.clear();
    this.resets = [];
    this.gaps = [];
  }

  /** Forgets marks whose rows have left the history. */
  private forgetMarks(): void {
    const { first } = this.history;
    while ((this.resets[0] ?? Infinity) < first) this.resets.shift();
    while ((this.gaps[0]?.to ?? Infinity) < first) this.gaps.shift();
  }
}
