// The transport over the history that this page has: of a live flight, which goes on meanwhile, or of an exported page.
import type { View } from "../plots/view";
import type { Stretch, Transport } from "./transport";

/** A playhead this near to the newest moment follows the flight, s. */
const AT_THE_EDGE_S = 0.005;
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];

/** The times of the flight that the transport needs. */
export interface Clock {
  /** Time of the newest tick, s. */
  now(): number;
  /** Time of the oldest tick of the history, s. */
  oldest(): number;
}

export class LocalTransport implements Transport {
  playing = false;
  speed = 1;
  loop: Stretch | null = null;
  readonly speeds = SPEEDS;

  /** `live` tells whether the flight goes on; otherwise the playhead stays within the history and never follows it. */
  constructor(
    private readonly view: View,
    private readonly clock: Clock,
    readonly live: boolean,
  ) {}

  get timeS(): number {
    return this.view.pinned ?? this.clock.now();
  }

  get oldestS(): number {
    return this.clock.oldest();
  }

  get newestS(): number {
    return this.clock.now();
  }

  get past(): boolean {
    return this.live && this.view.pinned !== null;
  }

  /** Plays from the playhead on, or stops. At the end an exported page starts over; a live flight is held where it is. */
  toggle(): void {
    this.playing = !this.playing && (!this.live || this.past);
    if (this.live && !this.past) return this.view.hold();
    if (this.playing && this.atEnd()) this.view.moveCursor(this.oldestS);
  }

  seek(timeS: number): void {
    if (this.live && timeS >= this.newestS - AT_THE_EDGE_S) return this.toNewest();
    this.view.moveCursor(timeS);
  }

  step(seconds: number): void {
    this.playing = false;
    this.seek(this.timeS + seconds);
  }

  toNewest(): void {
    this.playing = false;
    if (this.live) this.view.live();
    else this.view.moveCursor(this.newestS);
  }

  setSpeed(speed: number | null): void {
    this.speed = speed ?? Infinity;
  }

  toggleLoop(): void {
    this.loop = this.loop === null ? (this.view.marked() ?? { from: this.oldestS, to: this.newestS }) : null;
  }

  frame(elapsedS: number): void {
    if (!this.playing) return;
    const next = this.timeS + elapsedS * this.speed;
    if (this.loop !== null && next >= this.loop.to) return this.view.moveCursor(this.loop.from);
    if (next < this.newestS) return this.view.moveCursor(next);
    this.toNewest();
  }

  private atEnd(): boolean {
    return this.timeS >= this.newestS - AT_THE_EDGE_S;
  }
}
