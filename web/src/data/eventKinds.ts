// The kinds of events: each has a glyph, a word and a line pattern, the same in the event list and on the charts. Operators can
// tell kinds apart without colours.

export type Tone = "good" | "warn" | "bad";

export interface EventKind {
  kind: string;
  icon: string;
  label: string;
  tone?: Tone;
  /** Dash pattern of its line on the charts, px; an empty pattern is a solid line. */
  dash: number[];
  /** Where marks overlap, the mark with the largest weight is drawn. */
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
  { kind: "saturation", icon: "⊤", label: "saturation", tone: "warn", dash: [8, 3, 2, 3], weight: 6 },
  { kind: "verdict", icon: "■", label: "verdict", dash: [], weight: 8 },
];

const BY_NAME = new Map(EVENT_KINDS.map((kind) => [kind.kind, kind]));

/** The look of a kind; a kind that this page does not know gets a dot and its own name. */
export function eventKind(kind: string): EventKind {
  return BY_NAME.get(kind) ?? { kind, icon: "·", label: kind, dash: [1, 5], weight: 0 };
}
