// Events about gains, as the server words them: `Λ z (damping.z) 3.5 -> 8.5 since tick 98`. A dragged slider makes one at the start of
// the drag, and one when it has come to rest, which says since when the last value is in force.
import type { EventInfo } from "../protocol";

export interface GainChange {
  label: string;
  name: string;
  from: string;
  to: string;
}

/** The change that the text tells; null if the text tells something else. */
export function gainChange(text: string): GainChange | null {
  const [, label, name, from, to] = /^(.+) \(([\w.]+)\) (\S+) -> (\S+)$/.exec(text) ?? [];
  return label === undefined || name === undefined || from === undefined || to === undefined ? null : { label, name, from, to };
}

/** The event at the tick since which its value is in force. */
export function atEffect(event: EventInfo, tickS: number): EventInfo {
  const [, text, since] = /^(.+ -> \S+) since tick (\d+)$/.exec(event.text) ?? [];
  if (event.kind !== "gain" || text === undefined || since === undefined) return event;
  const tick = Number(since);
  return { ...event, text, tick, t_s: event.t_s - (event.tick - tick) * tickS };
}

/** One event for two changes of the same gain of which the second goes on where the first ended; null if they are not such a pair. */
export function joined(last: EventInfo, next: EventInfo): EventInfo | null {
  if (last.kind !== "gain" || next.kind !== "gain" || next.t_s - last.t_s > ONE_DRAG_S) return null;
  const [a, b] = [gainChange(last.text), gainChange(next.text)];
  if (a === null || b === null || a.name !== b.name || a.to !== b.from) return null;
  return { ...next, text: `${a.label} (${a.name}) ${a.from} -> ${b.to}` };
}

/** Changes of one gain that follow each other within this time are one drag, s. */
const ONE_DRAG_S = 5;
