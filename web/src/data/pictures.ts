// The pictures of the last minutes: where every body was at the ticks for which telemetry had a picture. A picture between two of them is
// interpolated, so that the playhead can stand on any tick; where no picture is near, there is none.
import type { Telemetry } from "../link/decode";
import { HISTORY_TICKS } from "./history";
import { blendPose, POSE_FLOATS } from "./pose";

/** Room is taken in blocks of this many ticks, so that a short flight takes little memory. */
const BLOCK_TICKS = 1024;
/** Two pictures that are farther apart than this have nothing between them, ticks. */
const LONGEST_GAP_TICKS = 25;
/** A frame has a picture of its newest tick only; it stands for the ticks of the frame too. */
const NEAR_TICKS = 3;
const NOTHING = new Float32Array();

/** The moving bodies and what touches them at one tick. */
export interface Picture {
  /** Poses of the moving bodies, then of the reference: x y z (m), w x y z each. */
  poses: Float32Array;
  contacts: Float32Array;
  spectrum: Float32Array;
}

export class Pictures {
  /** Tick of each slot; -1 while it is empty. */
  private readonly ticks: Int32Array;
  private readonly blocks: (Float32Array | undefined)[] = [];
  private contacts: (Float32Array | undefined)[] = [];
  private spectra: (Float32Array | undefined)[] = [];
  private width = 0;
  private first = NaN;
  private last = NaN;

  /** `capacity` is a power of two and a multiple of the block. */
  constructor(readonly capacity = HISTORY_TICKS) {
    this.ticks = new Int32Array(capacity).fill(-1);
  }

  /** Forgets all pictures. */
  clear(): void {
    this.ticks.fill(-1);
    this.first = NaN;
    this.last = NaN;
  }

  /** Keeps the picture of `frame`, which belongs to its newest row. */
  put(frame: Telemetry): void {
    if (frame.rows === 0) return;
    const tick = frame.firstTick + frame.rows - 1;
    const width = frame.poses.length + frame.reference.length;
    if (width !== this.width) this.resize(width);
    const slot = tick & (this.capacity - 1);
    const block = Math.floor(slot / BLOCK_TICKS);
    const poses = (this.blocks[block] ??= new Float32Array(BLOCK_TICKS * width));
    const at = (slot % BLOCK_TICKS) * width;
    poses.set(frame.poses, at);
    poses.set(frame.reference, at + frame.poses.length);
    // The frame's views share its memory with the channels; a copy lets this memory go.
    this.contacts[slot] = frame.contacts.length === 0 ? NOTHING : frame.contacts.slice();
    this.spectra[slot] = this.sameSpectrum(frame.spectrum) ?? frame.spectrum.slice();
    this.ticks[slot] = tick;
    this.first = Number.isNaN(this.first) ? tick : Math.max(Math.min(this.first, tick), tick - this.capacity + 1);
    this.last = Number.isNaN(this.last) ? tick : Math.max(this.last, tick);
  }

  /** The newest tick up to `tick` with a picture; NaN without one. */
  before(tick: number): number {
    for (let at = Math.min(tick, this.last); at >= this.first; at -= 1) if (this.has(at)) return at;
    return NaN;
  }

  /** The picture at `tick`: its own, one between its neighbours, or null if no picture is near. */
  at(tick: number): Picture | null {
    const before = this.before(tick);
    if (Number.isNaN(before)) return this.near(this.after(tick, tick + NEAR_TICKS));
    const [contacts, spectrum] = [this.contacts[this.slot(before)] ?? NOTHING, this.spectra[this.slot(before)] ?? NOTHING];
    if (before === tick) return { poses: this.poses(tick), contacts, spectrum };
    const after = this.after(tick, before + LONGEST_GAP_TICKS);
    if (Number.isNaN(after)) return this.near(tick - before <= NEAR_TICKS ? before : NaN);
    const [from, to] = [this.poses(before), this.poses(after)];
    const poses = new Float32Array(this.width);
    const part = (tick - before) / (after - before);
    for (let pose = 0; pose < this.width; pose += POSE_FLOATS) blendPose(poses, from, to, pose, part);
    return { poses, contacts, spectrum };
  }

  /** Calls `into` with every `every`-th picture from tick `from` up to, not including, `to`, oldest first. */
  between(from: number, to: number, every: number, into: (tick: number, poses: Float32Array) => void): void {
    const end = Math.min(to, this.last + 1);
    for (let tick = Math.max(from, this.first); tick < end; tick += 1) {
      if (tick % every === 0 && this.has(tick)) into(tick, this.poses(tick));
    }
  }

  /** Eigenvalues of the adapter's covariance at `tick`; empty if they are not known there. */
  spectrumAt(tick: number): Float32Array {
    const before = this.before(tick);
    return Number.isNaN(before) || tick - before > LONGEST_GAP_TICKS ? NOTHING : (this.spectra[this.slot(before)] ?? NOTHING);
  }

  /** The picture of `tick` itself; null for NaN. */
  private near(tick: number): Picture | null {
    return Number.isNaN(tick) ? null : this.at(tick);
  }

  private has(tick: number): boolean {
    return this.ticks[this.slot(tick)] === tick;
  }

  private after(tick: number, most: number): number {
    for (let at = tick + 1; at <= Math.min(most, this.last); at += 1) if (this.has(at)) return at;
    return NaN;
  }

  private slot(tick: number): number {
    return tick & (this.capacity - 1);
  }

  private poses(tick: number): Float32Array {
    const slot = this.slot(tick);
    const at = (slot % BLOCK_TICKS) * this.width;
    return this.blocks[Math.floor(slot / BLOCK_TICKS)]?.subarray(at, at + this.width) ?? NOTHING;
  }

  /** The newest spectrum if `spectrum` has the same numbers: telemetry repeats it for several ticks. */
  private sameSpectrum(spectrum: Float32Array): Float32Array | undefined {
    const last = Number.isNaN(this.last) ? undefined : this.spectra[this.slot(this.last)];
    return last !== undefined && last.length === spectrum.length && last.every((value, k) => value === spectrum[k]) ? last : undefined;
  }

  private resize(width: number): void {
    this.clear();
    this.width = width;
    this.blocks.length = 0;
    this.contacts = [];
    this.spectra = [];
  }
}
