// Link health: what the top bar shows about the connection, computed from arrival times alone.

/** Data older than this while flying is shown as stale, ms. */
export const STALE_AFTER_MS = 500;
/** While paused or ended only `state` messages come (2 Hz), ms. */
export const SILENT_AFTER_MS = 1600;
const RATE_WINDOW_MS = 1000;

export class LinkHealth {
  connected = false;
  gapTicks = 0;
  gapCount = 0;
  roundTripMs = NaN;
  /** Connections after the first. */
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

  /** Age of what the screen shows, ms: of telemetry while flying, of any word from the server otherwise. */
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

  /** Bytes that came over the socket, of whatever kind. */
  bytes(now: number, count: number): void {
    this.received.push({ at: now, bytes: count });
    this.forget(now);
  }

  bytesPerSecond(now: number): number {
    this.forget(now);
    return this.received.reduce((sum, { bytes }) => sum + bytes, 0) * (1000 / RATE_WINDOW_MS);
  }

  /** A connection is open. */
  open(now: number): void {
    if (this.opened) this.reconnects += 1;
    this.opened = true;
    this.connected = true;
    this.restart(now);
  }

  /** A new connection or a new flight: the counts belong to it alone. */
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

/** Wait before the next attempt to connect, ms: 0.25 s doubling to 4 s. */
export function backoffMs(failures: number): number {
  return Math.min(4000, 250 * 2 ** Math.min(failures, 10));
}
