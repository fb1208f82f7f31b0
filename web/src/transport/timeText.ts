// Times as an operator types and reads them.

/** A time as it stands beside the playhead: two decimals, and minutes from the first on. */
export function timeText(timeS: number): string {
  const minutes = Math.floor(timeS / 60 + 1e-9);
  const seconds = Math.max(0, timeS - 60 * minutes);
  return minutes === 0 ? seconds.toFixed(2) : `${minutes}:${seconds.toFixed(2).padStart(5, "0")}`;
}

/**
 * The time that a typed text means, s: `12.5`, `1:02.5`, `-17` (before the newest moment). Null if it is none of these.
 * `newestS` is the newest moment of the flight, s.
 */
export function parseTime(text: string, newestS: number): number | null {
  const found = /^([-−])?(?:(\d+):)?(\d+(?:[.,]\d*)?)\s*s?$/.exec(text.trim());
  if (found === null) return null;
  const [, minus, minutes, seconds] = found;
  const time = 60 * Number(minutes ?? 0) + Number((seconds ?? "").replace(",", "."));
  return minus === undefined ? time : newestS - time;
}

/** By how much the playhead is behind the flight. */
export function behindText(seconds: number): string {
  return `−${seconds < 100 ? seconds.toFixed(1) : seconds.toFixed(0)} s`;
}
