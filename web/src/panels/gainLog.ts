// The gains in force over the flight, so that a past moment is shown with its own. It is built from the values at the page's connection,
// from every change after it, and from the events about changes before it.
import { gainChange } from "../data/gainEvents";
import type { EventInfo, GainInfo } from "../protocol";

export class GainLog {
  private base = new Map<string, number>();
  private since = 0;
  private changes: { tick: number; name: string; value: number }[] = [];

  /** Starts over with the values in force from `tick` on. */
  start(gains: GainInfo[], tick: number): void {
    this.base = new Map(gains.map(({ name, value }) => [name, value]));
    this.since = tick;
    this.changes = [];
  }

  /** Notes that the gain `name` has `value` from `tick` on. */
  note(name: string, value: number, tick: number): void {
    this.changes.push({ tick, name, value });
  }

  /** The value of a gain at `tick`; null if nobody told this page. `events` are those of the flight, oldest first. */
  at(name: string, tick: number, events: EventInfo[]): number | null {
    if (tick >= this.since) return this.changes.filter((change) => change.name === name && change.tick <= tick).at(-1)?.value ?? this.base.get(name) ?? null;
    for (const event of events) {
      if (event.kind !== "gain" || event.tick <= tick || event.tick >= this.since) continue;
      const change = gainChange(event.text);
      // A preset changes gains that its event does not name.
      if (change === null) return null;
      if (change.name === name) return Number(change.from);
    }
    return this.base.get(name) ?? null;
  }
}
