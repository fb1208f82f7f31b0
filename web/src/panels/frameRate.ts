// Counts how often something is drawn.

const WINDOW_MS = 1000;

export class FrameRate {
  private drawn: number[] = [];

  /** Notes a drawing at `nowMs`. */
  frame(nowMs: number): void {
    this.drawn.push(nowMs);
    while ((this.drawn[0] ?? nowMs) < nowMs - WINDOW_MS) this.drawn.shift();
  }

  /** Drawings per second over the last second. */
  at(nowMs: number): number {
    return this.drawn.filter((time) => time >= nowMs - WINDOW_MS).length * (1000 / WINDOW_MS);
  }
}
