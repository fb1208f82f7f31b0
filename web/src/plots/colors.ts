// The colours of the charts, read from the tokens of the current theme. Drawing on a canvas needs them as values.
import { tokenReader } from "../style/tokens";

export interface ChartColors {
  ink: string;
  muted: string;
  grid: string;
  panel: string;
  edge: string;
  estimate: string;
  setpoint: string;
  third: string;
  fourth: string;
  good: string;
  warn: string;
  bad: string;
  /** The colours of Okabe and Ito for charts with many lines, in an order in which neighbours differ most. */
  series: string[];
  /** The colours of forks, by their slot. */
  forks: string[];
}

export const SERIES_COLORS = 8;
/** As many forks as the server keeps. */
const FORK_COLORS = 6;
/** Dash patterns of lines, px. They let a reader tell lines apart without colours. */
export const SERIES_DASHES: (number[] | undefined)[] = [undefined, [7, 3], [2, 2], [9, 3, 2, 3], undefined, [5, 2], [1, 3], [12, 3]];

export function readColors(): ChartColors {
  const value = tokenReader();
  return {
    ink: value("ink"),
    muted: value("muted"),
    grid: value("grid"),
    panel: value("panel"),
    edge: value("edge"),
    estimate: value("estimate"),
    setpoint: value("setpoint"),
    third: value("third"),
    fourth: value("fourth"),
    good: value("good"),
    warn: value("warn"),
    bad: value("bad"),
    forks: Array.from({ length: FORK_COLORS }, (_, k) => value(`fork-${k + 1}`)),
    series: Array.from({ length: SERIES_COLORS }, (_, k) => value(`series-${k + 1}`)),
  };
}
