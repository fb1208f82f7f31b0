// When texts that change all the time are written: a changed text has the browser lay out and paint the whole page again, so
// all of them change in the same frame, and in no other. Nobody reads numbers that change faster.

const PERIOD_MS = 200;

/** The beats of all who ask with the time of the same frames fall together. */
export class Beat {
  private last = NaN;

  /** True once per beat; `now` is the time of the frame, ms. */
  due(now: number): boolean {
    const beat = Math.floor(now / PERIOD_MS);
    if (beat === this.last) return false;
    this.last = beat;
    return true;
  }
}
