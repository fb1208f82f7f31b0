// The transport of a mirrored recording. The server plays it, so a move is a request, and every page that looks sees it.
import type { Store } from "../data/store";
import { Throttle } from "../panels/throttle";
import type { ClientMessage, MirrorInfo } from "../protocol";
import type { Stretch, Transport } from "./transport";

/** The least time between two seeks of a dragged playhead, ms. At each seek the shadow flies the ten seconds before the target. */
const SEEK_EVERY_MS = 150;
/** A time after the end of any stream, s. The server seeks the newest tick instead. */
const NEWEST_S = 1e6;
/** A playhead this near to the end of a recording is at the end, ticks. */
const AT_END_TICKS = 2;
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, null];

export class MirrorTransport implements Transport {
  readonly speeds = SPEEDS;
  loop: Stretch | null = null;
  private readonly throttle = new Throttle(SEEK_EVERY_MS, (tS) => this.send({ type: "seek", t_s: tS }));
  /** Newest time of a stream that was seen, s. */
  private seenS = 0;
  /** Target of the last seek, until the flight has come there, s. */
  private wanted: number | null = null;

  /** `marked` returns the stretch that is marked on the charts; null if there is none. */
  constructor(
    private readonly store: Store,
    private info: MirrorInfo,
    private readonly send: (request: ClientMessage) => void,
    private readonly marked: () => Stretch | null,
  ) {}

  get timeS(): number {
    return this.wanted ?? this.arrivedS;
  }

  readonly oldestS = 0;

  get newestS(): number {
    this.seenS = Math.max(this.seenS, this.arrivedS);
    return this.info.live ? this.seenS : this.info.duration_s;
  }

  get live(): boolean {
    return this.info.live;
  }

  get past(): boolean {
    return false;
  }

  get playing(): boolean {
    return this.store.state?.phase === "flying";
  }

  get speed(): number | null {
    return this.store.state === null ? 1 : this.store.state.speed;
  }

  toggle(): void {
    this.send({ type: "pause", paused: this.playing });
  }

  seek(timeS: number): void {
    this.wanted = Math.min(Math.max(timeS, 0), this.newestS);
    this.throttle.ask(this.wanted);
  }

  step(seconds: number): void {
    if (this.playing) this.send({ type: "pause", paused: true });
    this.seek(this.timeS + seconds);
  }

  toNewest(): void {
    this.wanted = null;
    this.throttle.ask(this.info.live ? NEWEST_S : this.info.duration_s);
  }

  setSpeed(speed: number | null): void {
    this.send({ type: "speed", value: speed });
  }

  toggleLoop(): void {
    this.loop = this.loop === null ? (this.marked() ?? { from: 0, to: this.info.duration_s }) : null;
  }

  /** Restarts the loop at its end. */
  frame(): void {
    if (this.loop === null || this.wanted !== null) return;
    // At the end of the recording the server pauses by itself, so a loop to there goes on from the pause.
    const inside = this.loop.to < this.info.duration_s - AT_END_TICKS * this.store.tickS;
    if (inside && this.playing && this.timeS >= this.loop.to - this.store.tickS) this.seek(this.loop.from);
    else if (this.atEnd()) {
      this.seek(this.loop.from);
      this.send({ type: "pause", paused: false });
    }
  }

  /** Takes the description in a new `hello`: the flight has come to the target of a seek. */
  arrived(info: MirrorInfo): void {
    this.info = info;
    this.wanted = null;
  }

  private get arrivedS(): number {
    const tick = this.store.lastTick >= 0 ? this.store.lastTick : (this.store.state?.tick ?? 0);
    return tick * this.store.tickS;
  }

  /** Whether the recording has been played to its end and is paused there. */
  private atEnd(): boolean {
    return this.store.state?.phase === "paused" && !this.info.live && this.timeS >= this.info.duration_s - AT_END_TICKS * this.store.tickS;
  }
}
