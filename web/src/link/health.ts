// The health of the connection, which the top bar shows. It is computed from arrival times alone.

/** While a flight runs, data older than this count as stale, ms. */
export const STALE_AFTER_MS = 500;
/** The same limit while the flight is paused or has ended, ms. It is longer because only `state` messages come then (2 Hz). */
export const SILENT_AFTER_MS = 1600;
const RATE_WINDOW_MS = 1000;

export class LinkHealth {
  connected = false;
  gapTicks = 0;
  gapCount = 0;
  roundTripMs = NaN;
  /** Number of connections after the first one. */
  reconnects = 0;
  private opened = false;
  private lastMessage = -Infinity;
  private lastTelemetry = -Infinity;
  private arrivals: number[] = [];
  private received: { at: number; bytes: number }[] = [];

  message(now: number): void {
    this.lastMessage = now;
  }

  telemetry(now: number, gap: number): void {
    this.lastMessage = now;
    this.lastTelemetry = now;
    this.arrivals.push(now);
    this.forget(now);
    if (gap > 0) {
      this.gapCount += 1;
      this.gapTicks += gap;
    }
  }

  /** Age of the data on the screen, ms: time since the newest telemetry while a flight runs, else since the newest message. */
  ageMs(now: number, flying: boolean): number {
    return Math.max(0, now - (flying ? this.lastTelemetry : this.lastMessage));
  }

  stale(now: number, flying: boolean): boolean {
    return !this.connected || this.ageMs(now, flying) > (flying ? STALE_AFTER_MS : SILENT_AFTER_MS);
  }

  framesPerSecond(now: number): number {
    this.forget(now);
    return this.arrivals.length * (1000 / RATE_WINDOW_MS);
  }

  /** Counts bytes of any message that came over the socket. */
  bytes(now: number, count: number): void {
    this.received.push({ at: now, bytes: count });
    this.forget(now);
  }

  bytesPerSecond(now: number): number {
    this.forget(now);
    return this.received.reduce((sum, { bytes }) => sum + bytes, 0) * (1000 / RATE_WINDOW_MS);
  }

  /** Notes that a connection has opened. */
  open(now: number): void {
    if (this.opened) this.reconnects += 1;
    this.opened = true;
    this.connected = true;
    this.restart(now);
  }

  /** Restarts all counts, for a new connection or a new flight. */
  restart(now: number): void {
    this.gapTicks = 0;
    this.gapCount = 0;
    this.arrivals = [];
    this.lastMessage = now;
    this.lastTelemetry = now;
  }

  private forget(now: number): void {
    const since = now - RATE_WINDOW_MS;
    while ((this.arrivals[0] ?? now) < since) this.arrivals.shift();
    while ((this.received[0]?.at ?? now) < since) this.received.shift();
  }
}

/** Time to wait before the next attempt to connect, ms. It starts at 0.25 s and doubles with each failure up to 4 s. */
export function backoffMs(failures: number): number {
  return Math.min(4000, 250 * 2 ** Math.min(failures, 10));
}
