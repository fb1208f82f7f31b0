// The last of many wishes, and not too often.

export class Throttle {
  private waiting: number | null = null;
  private timer: ReturnType<typeof setTimeout> | null = null;

  /** `act` is called at once for a first wish, and then at most every `everyMs` with the newest. */
  constructor(
    private readonly everyMs: number,
    private readonly act: (value: number) => void,
  ) {}

  ask(value: number): void {
    if (this.timer !== null) {
      this.waiting = value;
      return;
    }
    this.act(value);
    this.timer = setTimeout(() => {
      this.timer = null;
      this.flush();
    }, this.everyMs);
  }

  /** What still waits, now. */
  flush(): void {
    const { waiting } = this;
    this.waiting = null;
    if (waiting !== null) this.ask(waiting);
  }
}
