// Writes a stretch of the history as comma-separated values: every tick, in physical units, without decimation.
import type { History } from "./history";

export interface CsvColumn {
  column: number;
  name: string;
  unit: string;
}

/**
 * One line for each tick `from` to `to`, both included, that the history has. A lost tick has no line; an unknown value is `NaN`.
 * `lost` tells whether a tick was lost on the way to this page.
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

/** The shortest decimal number that is read back as the same 32-bit float. */
export function shortest(value: number): string {
  if (!Number.isFinite(value)) return String(value);
  for (let digits = 6; digits < 9; digits += 1) {
    const text = Number(value.toPrecision(digits));
    if (Math.fround(text) === Math.fround(value)) return String(text);
  }
  return String(Number(value.toPrecision(9)));
}

/** The text as a field of a line, with quotes if RFC 4180 demands them. */
function field(text: string): string {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
