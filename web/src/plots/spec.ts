// What each chart shows. Estimates are vermilion, set-points and limits bluish green and dashed; a line's kind never
// rests on its colour alone.
import type { Palette } from "../panels/theme";

export interface SeriesSpec {
  channel: string;
  label: string;
  color: keyof Palette;
  dash?: number[];
  /** Drawn as steps: a value that is set, not measured. */
  stepped?: boolean;
}

export interface ChartSpec {
  key: string;
  title: string;
  logarithmic?: boolean;
  /** Resets carry their icon here; everywhere else the dashed line is enough. */
  resetIcon?: boolean;
  /** Smaller changes are not worth the height of the chart, in the chart's unit. */
  smallestSpan: number;
  series: SeriesSpec[];
}

const SYMBOLS: Record<string, string> = { phi: "φ", theta: "θ", psi: "ψ", q1: "q₁", q2: "q₂" };

/** The coordinate's symbol. */
export function symbolOf(row: string): string {
  return SYMBOLS[row] ?? row;
}

/** The charts of the console for one row of the coordinates. */
export function chartSpecs(row: string): ChartSpec[] {
  const symbol = symbolOf(row);
  return [
    {
      key: "residual",
      title: `Residual ${symbol}`,
      smallestSpan: 0.2,
      series: [
        { channel: `residual.${row}`, label: "measured", color: "muted" },
        { channel: `base.${row}`, label: "base", color: "third", dash: [7, 3] },
        { channel: `adapted.${row}`, label: "adapted", color: "estimate" },
      ],
    },
    {
      key: "innovation",
      title: "Innovation",
      logarithmic: true,
      resetIcon: true,
      smallestSpan: 1,
      series: [
        { channel: "innovation_mean", label: "mean", color: "estimate" },
        { channel: "reset_threshold", label: "δ", color: "setpoint", dash: [6, 4], stepped: true },
      ],
    },
    {
      key: "covariance",
      title: "Covariance trace",
      logarithmic: true,
      smallestSpan: 1,
      series: [{ channel: "covariance_trace", label: "tr Σ", color: "third" }],
    },
    {
      key: "robust",
      title: "Robust term",
      smallestSpan: 0.1,
      series: [
        { channel: "robust_gain", label: "σ̂", color: "estimate" },
        { channel: "sliding_norm", label: "‖s‖", color: "third" },
      ],
    },
    {
      key: "tracking",
      title: "Tracking error",
      smallestSpan: 0.02,
      series: [
        { channel: "position_error_m", label: "position", color: "estimate" },
        { channel: `error.${row}`, label: symbol, color: "third" },
      ],
    },
  ];
}
