// A stretch of history as comma-separated values: every tick, physical units, nothing decimated.
import type { History } from "./history";

export interface CsvColumn {
  column: number;
  name: string;
  unit: string;
}

/**
 * The ticks `from` to `to`, both included, as far as they are held. A lost tick has no line; an unknown value is `NaN`.
 * `lost` says which ticks never came.
 */
export function csvOf(history: History, columns: CsvColumn[], from: number, to: number, timeOf: (tick: number) => number, lost: (tick: number) => boolean): string {
  const head = ["tick", "t_s", ...columns.map(({ name, unit }) => field(unit === "" ? name : `${name} [${unit}]`))];
  const lines = [head.join(",")];
  const end = Math.min(to, history.last);
  for (let tick = Math.max(from, history.first); tick <= end; tick += 1) {
    if (lost(tick)) continue;
    const values = columns.map(({ column }) => shortest(history.at(column, tick)));
    lines.push([tick, Number(timeOf(tick).toFixed(6)), ...values].join(","));
  }
  return `${lines.join("\r\n")}\r\n`;
}

/** The shortest decimal that reads back as the same 32-bit float. */
export function shortest(value: number): string {
  if (!Number.isFinite(value)) return String(value);
  for (let digits = 6; digits < 9; digits += 1) {
    const text = Number(value.toPrecision(digits));
    if (Math.fround(text) === Math.fround(value)) return String(text);
  }
  return String(Number(value.toPrecision(9)));
}

/** Quoted where RFC 4180 asks for it. */
function field(text: string): string {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
