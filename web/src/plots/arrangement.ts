// Which charts the operator wants to see, and how; it outlives the page.

export interface OwnChart {
  key: string;
  title: string;
  /** Names, in the order they were added. */
  channels: string[];
}

export interface Arrangement {
  /** Keys of charts that are not shown. */
  hidden: string[];
  own: OwnChart[];
  /** Residuals as z-scores. */
  zscore: boolean;
  /** Kinds of events that are not marked on the charts. */
  unmarked: string[];
  windowS: number;
  row: string;
}

export const WINDOWS_S = [5, 10, 20, 60, 300, 600];
export const MOST_OWN = 8;
const STORED = "twin.charts";

/** Every chart, every mark, physical units. */
export function standard(): Arrangement {
  return { hidden: [], own: [], zscore: false, unmarked: [], windowS: 20, row: "z" };
}

/** Reads what was stored; whatever cannot be used is replaced by the standard, piece by piece. */
export function parse(text: string | null): Arrangement {
  const fallback = standard();
  let stored: unknown;
  try {
    stored = JSON.parse(text ?? "null");
  } catch {
    return fallback;
  }
  if (typeof stored !== "object" || stored === null) return fallback;
  const read = stored as Record<string, unknown>;
  return {
    hidden: strings(read["hidden"]),
    own: (Array.isArray(read["own"]) ? read["own"] : []).flatMap(ownChart).slice(0, MOST_OWN),
    zscore: read["zscore"] === true,
    unmarked: strings(read["unmarked"]),
    windowS: WINDOWS_S.find((seconds) => seconds === read["windowS"]) ?? fallback.windowS,
    row: typeof read["row"] === "string" ? read["row"] : fallback.row,
  };
}

export function load(): Arrangement {
  return parse(localStorage.getItem(STORED));
}

export function save(arrangement: Arrangement): void {
  localStorage.setItem(STORED, JSON.stringify(arrangement));
}

/** A new, empty chart under a key that is not in use. */
export function addOwn(arrangement: Arrangement): OwnChart | null {
  if (arrangement.own.length >= MOST_OWN) return null;
  const free = Array.from({ length: MOST_OWN }, (_, k) => k + 1).find((k) => !arrangement.own.some(({ key }) => key === `own-${k}`)) ?? 1;
  const own = { key: `own-${free}`, title: `Chart ${free}`, channels: [] };
  arrangement.own.push(own);
  return own;
}

function strings(value: unknown): string[] {
  return Array.isArray(value) ? value.filter((item): item is string => typeof item === "string") : [];
}

function ownChart(value: unknown): OwnChart[] {
  if (typeof value !== "object" || value === null) return [];
  const { key, title, channels } = value as Record<string, unknown>;
  if (typeof key !== "string" || typeof title !== "string") return [];
  return [{ key, title, channels: strings(channels) }];
}
