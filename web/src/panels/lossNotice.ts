// Tells the operator that ticks were lost, but seldom enough that the notices can be read.

/** At most one notice in this time, ms. */
const NOT_MORE_OFTEN_MS = 10_000;

export class LossNotice {
  private pending = 0;
  private saidAt = -Infinity;

  constructor(private readonly say: (text: string) => void) {}

  /** Notes that `ticks` were lost just now. */
  lost(ticks: number): void {
    this.pending += ticks;
  }

  /** Shows a notice if one is due; called regularly. */
  due(nowMs: number): void {
    if (this.pending === 0 || nowMs - this.saidAt < NOT_MORE_OFTEN_MS) return;
    const { pending } = this;
    this.pending = 0;
    this.saidAt = nowMs;
    this.say(`${pending} ${pending === 1 ? "tick" : "ticks"} lost on the way to this page; the charts show a gap there. The flight and its recording are complete.`);
  }
}
