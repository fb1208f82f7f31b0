// Joins marks that would overlap to one cluster.
import { type EventKind, eventKind } from "../data/eventKinds";

export interface Mark {
  tick: number;
  /** Time of the mark, s. */
  time: number;
  kind: string;
  /** The text of the mark, one sentence. */
  text: string;
}

export interface Cluster {
  /** Position of the mark that represents the cluster, px. */
  x: number;
  /** The mark that represents the cluster: the first of those with the largest weight. */
  head: Mark;
  marks: Mark[];
}

/** Kinds of marks that are not events. */
const OWN_KINDS: EventKind[] = [
  { kind: "gap", icon: "⋮", label: "lost ticks", tone: "warn", dash: [], weight: 3 },
  { kind: "marker", icon: "⚑", label: "your mark", dash: [], weight: 10 },
];

export function markKind(kind: string): EventKind {
  return OWN_KINDS.find((own) => own.kind === kind) ?? eventKind(kind);
}

/** Groups the ascending `marks` into clusters that begin at least `apart` px from one another. */
export function clusters(marks: Mark[], xOf: (time: number) => number, apart: number): Cluster[] {
  const groups: { from: number; marks: Mark[] }[] = [];
  for (const mark of marks) {
    const x = xOf(mark.time);
    const group = groups.at(-1);
    if (group !== undefined && x - group.from < apart) group.marks.push(mark);
    else groups.push({ from: x, marks: [mark] });
  }
  return groups.map((group) => {
    const head = group.marks.reduce((best, mark) => (markKind(mark.kind).weight > markKind(best.kind).weight ? mark : best));
    return { x: xOf(head.time), head, marks: group.marks };
  });
}
