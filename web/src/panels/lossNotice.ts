// Tells the operator that samples were lost, seldom enough to be read.

/** At most one notice in this time, ms. */
const NOT_MORE_OFTEN_MS = 10_000;

export class LossNotice {
  private pending = 0;
  private saidAt = -Infinity;

  constructor(private readonly say: (text: string) => void) {}

  /** `ticks` were lost just now. */
  lost(ticks: number): void {
    this.pending += ticks;
  }

  /** Called now and then. */
  due(nowMs: number): void {
    if (this.pending === 0 || nowMs - this.saidAt < NOT_MORE_OFTEN_MS) return;
    const { pending } = this;
    this.pending = 0;
    this.saidAt = nowMs;
    this.say(`${pending} ${pending === 1 ? "tick" : "ticks"} lost on the way to this page: charts show a break there. The flight and its recording have them.`);
  }
}
