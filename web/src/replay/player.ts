// The clock of a replay, and the frame that it shows. Its time is the time of the charts' cursor, so both always move together.
import type { Telemetry } from "../link/decode";

/** A move over at most this many frames shows each of them; a longer move is a jump. */
const FOLLOWED_FRAMES = 20;
/** After a jump the trail reaches back this long, s, with one of `TRAIL_EVERY` frames. */
const TRAIL_S = 20;
const TRAIL_EVERY = 4;

export interface Screen {
  clear(): void;
  update(frame: Telemetry): void;
}

export class Player {
  playing = false;
  /** Simulated seconds per second. */
  speed = 1;
  private shown = -1;

  constructor(
    private readonly frames: Telemetry[],
    private readonly screen: () => Screen | null,
  ) {}

  get endS(): number {
    return this.frames.at(-1)?.tSim ?? 0;
  }

  get startS(): number {
    return this.frames[0]?.tSim ?? 0;
  }

  /** Time of the clock `elapsed` s after `time`; it stops at the end. */
  advance(time: number, elapsed: number): number {
    if (!this.playing) return time;
    const next = Math.min(this.endS, time + elapsed * this.speed);
    if (next >= this.endS) this.playing = false;
    return next;
  }

  /** Plays or stops; at the end it starts over. Returns the time from which to go on. */
  toggle(time: number): number {
    this.playing = !this.playing;
    return this.playing && time >= this.endS ? this.startS : time;
  }

  /** Shows the newest frame that is not after `time`. */
  show(time: number): void {
    const screen = this.screen();
    const wanted = frameAt(this.frames, time);
    if (screen === null || wanted === this.shown || wanted < 0) return;
    const near = wanted > this.shown && wanted - this.shown <= FOLLOWED_FRAMES && this.shown >= 0;
    if (!near) screen.clear();
    for (const frame of near ? this.frames.slice(this.shown + 1, wanted) : this.trail(wanted)) screen.update(frame);
    const frame = this.frames[wanted];
    if (frame !== undefined) screen.update(frame);
    this.shown = wanted;
  }

  private trail(wanted: number): Telemetry[] {
    const from = frameAt(this.frames, (this.frames[wanted]?.tSim ?? 0) - TRAIL_S);
    return this.frames.slice(Math.max(0, from), wanted).filter((_, index) => index % TRAIL_EVERY === 0);
  }
}

/** Index of the newest frame that is not after `time`; 0 if all frames are after it, -1 without frames. */
export function frameAt(frames: Telemetry[], time: number): number {
  let [low, high] = [0, frames.length - 1];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if ((frames[middle]?.tSim ?? Infinity) <= time + 1e-6) low = middle;
    else high = middle - 1;
  }
  return high;
}
