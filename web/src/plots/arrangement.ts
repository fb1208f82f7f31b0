// The operator's arrangement of the charts; it is kept when the page is closed.

export interface OwnChart {
  key: string;
  title: string;
  /** Names of the channels, in the order in which they were added. */
  channels: string[];
}

export interface Arrangement {
  /** Keys of the hidden charts. */
  hidden: string[];
  own: OwnChart[];
  /** Whether residuals are shown as z-scores. */
  zscore: boolean;
  /** Kinds of events whose marks are hidden. */
  unmarked: string[];
  windowS: number;
  row: string;
}

export const WINDOWS_S = [2, 5, 10, 20, 60, 300, 600];
export const MOST_OWN = 8;
const STORED = "twin.charts";

/** The default arrangement: every chart, every mark, physical units. */
export function standard(): Arrangement {
  return { hidden: [], own: [], zscore: false, unmarked: [], windowS: 20, row: "z" };
}

/** Reads a stored arrangement; each part that cannot be used is replaced by the default of this part. */
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

/** Adds a new, empty chart under an unused key; returns null if there are as many own charts as allowed. */
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
