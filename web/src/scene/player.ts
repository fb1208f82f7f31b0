// Shows past moments in the 3-D view: the picture at the playhead with the path that leads to it.
import type { Store } from "../data/store";
import type { Telemetry } from "../link/decode";
import { POSE_FLOATS } from "../data/pose";
import type { Picture } from "../data/pictures";

/** A move over at most this many ticks adds to the path; a longer one, or one back, draws the path anew. */
const FOLLOWED_TICKS = 40;
/** The path is drawn with every so many ticks, and reaches back at most this long, s. */
const TRAIL_EVERY = 4;
const LONGEST_TRAIL_S = 60;

/** What the player needs of the 3-D view. */
export interface Screen {
  readonly settings: { trailS: number };
  update(frame: Telemetry): void;
  /** Shows `frame` at the end of another path, whose points `path` hands over. */
  retrace(path: (point: (timeS: number, poses: Float32Array) => void) => void, frame: Telemetry): void;
  /** Shows that there is no picture, or shows pictures again. */
  conceal(hidden: boolean): void;
}

export class ScenePlayer {
  private shown = NaN;

  constructor(
    private readonly store: Store,
    private readonly screen: () => Screen | null,
  ) {}

  /** Shows the moment at `tick`; returns false if this page has no picture near it. */
  show(tick: number): boolean {
    const screen = this.screen();
    if (screen === null || tick === this.shown) return true;
    const picture = this.store.pictures.at(tick);
    screen.conceal(picture === null);
    if (picture === null) {
      this.shown = NaN;
      return false;
    }
    const frame = this.frame(tick, picture);
    const follows = tick > this.shown && tick - this.shown <= FOLLOWED_TICKS;
    if (follows) screen.update(frame);
    else screen.retrace((point) => this.path(tick, screen.settings.trailS, point), frame);
    this.shown = tick;
    return true;
  }

  /** Shows the newest moment again, with the path that leads to it. */
  live(): void {
    this.shown = NaN;
    if (this.store.newest !== null) this.show(this.store.history.last);
    this.shown = NaN;
  }

  private path(tick: number, trailS: number, point: (timeS: number, poses: Float32Array) => void): void {
    const from = tick - Math.round(Math.min(LONGEST_TRAIL_S, trailS) / this.store.tickS);
    this.store.pictures.between(from, tick, TRAIL_EVERY, (at, poses) => point(this.store.timeOf(at), poses));
  }

  private frame(tick: number, { poses, contacts, spectrum }: Picture): Telemetry {
    const channels = this.store.row(tick);
    const bodies = poses.length - POSE_FLOATS;
    return {
      schemaId: 0, firstTick: tick, rows: 1, channelCount: channels.length, gap: 0, reset: false, tSim: this.store.timeOf(tick), tWall: 0,
      channels, poses: poses.subarray(0, bodies), reference: poses.subarray(bodies), contacts, spectrum,
    };
  }
}
