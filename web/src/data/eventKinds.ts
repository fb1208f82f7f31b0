// The kinds of events: glyph, word and line of each, the same in the list and on the charts. A kind never rests on its
// colour alone.

export type Tone = "good" | "warn" | "bad";

export interface EventKind {
  kind: string;
  icon: string;
  label: string;
  tone?: Tone;
  /** Pattern of its line on the charts, px; none is a solid line. */
  dash: number[];
  /** Drawn over the others where marks lie on top of one another. */
  weight: number;
}

export const EVENT_KINDS: EventKind[] = [
  { kind: "phase", icon: "▸", label: "phase", dash: [1, 5], weight: 1 },
  { kind: "grasp", icon: "⊓", label: "grasp", tone: "good", dash: [6, 3, 1, 3], weight: 4 },
  { kind: "release", icon: "⊔", label: "release", tone: "good", dash: [6, 3, 1, 3], weight: 4 },
  { kind: "retry", icon: "⟲", label: "retry", tone: "warn", dash: [2, 2], weight: 5 },
  { kind: "reset", icon: "↺", label: "reset", tone: "warn", dash: [4, 3], weight: 7 },
  { kind: "gain", icon: "◆", label: "gain", dash: [2, 6], weight: 2 },
  { kind: "disturbance", icon: "≈", label: "disturbance", tone: "warn", dash: [8, 3], weight: 6 },
  { kind: "fault", icon: "▲", label: "fault", tone: "bad", dash: [], weight: 9 },
  { kind: "verdict", icon: "■", label: "verdict", dash: [], weight: 8 },
];

const BY_NAME = new Map(EVENT_KINDS.map((kind) => [kind.kind, kind]));

/** What is known of a kind; one that this page has not heard of gets a dot and its own name. */
export function eventKind(kind: string): EventKind {
  return BY_NAME.get(kind) ?? { kind, icon: "·", label: kind, dash: [1, 5], weight: 0 };
}
