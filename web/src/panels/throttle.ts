// Limits how often an action runs; between two runs only the newest value waits.

export class Throttle {
  private waiting: number | null = null;
  private timer: ReturnType<typeof setTimeout> | null = null;

  /** `act` is called at once for the first value, and then at most every `everyMs` with the newest value. */
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

  /** Calls `act` now if a value waits. */
  flush(): void {
    const { waiting } = this;
    this.waiting = null;
    if (waiting !== null) this.ask(waiting);
  }
}
