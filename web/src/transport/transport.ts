// The interface of a transport: what moves the playhead of the page. A live flight, a mirrored recording and an exported page each have one.

/** A stretch of the flight, s. */
export interface Stretch {
  from: number;
  to: number;
}

export interface Transport {
  /** Time at the playhead, s. */
  readonly timeS: number;
  /** Range of times at which the playhead can stand, s. */
  readonly oldestS: number;
  readonly newestS: number;
  /** Whether the flight goes on beyond the playhead, or an operator can go on with it there. */
  readonly live: boolean;
  /** Whether the playhead stands before the newest moment of a live flight. */
  readonly past: boolean;
  /** Whether the playhead moves by itself. */
  readonly playing: boolean;
  /** Seconds of the flight per second; null is as fast as the machine can. */
  readonly speed: number | null;
  /** The speeds that may be chosen. */
  readonly speeds: (number | null)[];
  /** The stretch that is played again and again; null without a loop. */
  readonly loop: Stretch | null;
  toggle(): void;
  seek(timeS: number): void;
  /** Moves by `seconds` and stops there. */
  step(seconds: number): void;
  toNewest(): void;
  setSpeed(speed: number | null): void;
  /** Plays the marked stretch, or else everything, again and again; or stops to do so. */
  toggleLoop(): void;
  /** The page is drawn, `elapsedS` after the last time. */
  frame(elapsedS: number): void;
}
