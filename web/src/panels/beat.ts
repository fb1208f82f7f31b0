// Decides when texts that change all the time are written: five times a second, because nobody reads faster. A changed text makes
// the browser lay out and paint the whole page, so all these texts change in the same frame.

const PERIOD_MS = 200;

/** Beats at a fixed period. All instances beat in the same frame if they are asked in each frame. */
export class Beat {
  private last = NaN;

  /** Returns true once per period; `now` is the time of the frame, ms. */
  due(now: number): boolean {
    const beat = Math.floor(now / PERIOD_MS);
    if (beat === this.last) return false;
    this.last = beat;
    return true;
  }
}
