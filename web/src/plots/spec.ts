// The content of each chart. Estimates are vermilion; set-points and limits are bluish green and dashed, so that a reader can tell
// them apart without colours.
import type { ChannelInfo } from "../protocol";
import type { OwnChart } from "./arrangement";
import type { ChartColors } from "./colors";
import { SERIES_COLORS, SERIES_DASHES } from "./colors";
import { BAND_90 } from "./fan";

export interface SeriesSpec {
  channel: string;
  label: string;
  /** A named colour, or an index into the list of colours. */
  color: Exclude<keyof ChartColors, "series" | "forks"> | number;
  dash?: number[];
  /** Whether the line is drawn as steps, because the value is set and not measured. */
  stepped?: boolean;
  /** Whether line and legend are hidden until the first known value. A predictor that does not look ahead never has one. */
  whenKnown?: boolean;
  /** Factor by which the channel is multiplied. */
  factor?: number;
  /** Whether the line has no place in the legend, because another line stands for both. */
  silent?: boolean;
}

export interface ChartSpec {
  key: string;
  title: string;
  logarithmic?: boolean;
  /** Whether resets have their icon on this chart; on the other charts they have a dashed line only. */
  resetIcon?: boolean;
  /** Whether values may be shown as z-scores. */
  zscore?: boolean;
  /** Indices of the two series that bound a filled area: upper, lower. */
  band?: [number, number];
  /** Coordinate whose fan of forecasts is drawn ahead of the cursor, or of now. */
  fan?: string;
  /** Whether the chart is taller than the others. */
  tall?: boolean;
  /** Smallest span of the value axis, in the chart's unit, so that noise does not fill the chart. */
  smallestSpan: number;
  series: SeriesSpec[];
}

/** Key of the panel with the newest spectrum as bars, which has no time axis. */
export const SPECTRUM = "spectrum";
/** Key of the panel with the errors of all coordinates at a glance. */
export const MULTIPLES = "multiples";
/** Key of the panel with the forecast from close by, which has a time axis of its own. */
export const CLOSE_UP = "foresight";

const SYMBOLS: Record<string, string> = { phi: "φ", theta: "θ", psi: "ψ", q1: "q₁", q2: "q₂" };

/** Symbol of a coordinate. */
export function symbolOf(row: string): string {
  return SYMBOLS[row] ?? row;
}

/** The console's charts for one coordinate, the most important first. A mirrored recording has no charts of the controller. */
export function chartSpecs(row: string, channels: ChannelInfo[], mirrored = false): ChartSpec[] {
  const known = new Set(channels.map(({ name }) => name));
  const heavy = channels.some(({ name, weight }) => name === `residual.${row}` && (weight ?? null) !== null);
  const of = `${symbolOf(row)}${heavy ? " − weight" : ""}`;
  return [residualSpec(row, of), ...(mirrored ? [] : [closeUpSpec(row, of)]), ...learningSpecs(), ...(mirrored ? mirrorSpecs(row) : controlSpecs(row)), ...multiplesSpec(channels), ...adapterSpecs(), ...(mirrored ? [] : [...forceSpecs(row), ...bodySpecs(channels)])]
    .map((spec) => ({ ...spec, series: spec.series.filter(({ channel }) => known.has(channel)) }))
    .filter(({ key, series }) => series.length > 0 || key === SPECTRUM || key === MULTIPLES);
}

/** Panel with the errors of the forecasts of all coordinates; none without z-scores, which alone can be compared. */
function multiplesSpec(channels: ChannelInfo[]): ChartSpec[] {
  const scored = channels.some(({ name, z_scale }) => name.startsWith("residual.") && z_scale !== null);
  return scored ? [{ key: MULTIPLES, title: "Errors of all coordinates", smallestSpan: 0.5, tall: true, series: [] }] : [];
}

/** Chart of the residual and its forecasts. The known weight is left out, because beside it no difference could be seen. */
function residualSpec(row: string, of: string): ChartSpec {
  return {
    key: "residual",
    title: `Residual ${of}`,
    smallestSpan: 0.2,
    zscore: true,
    fan: row,
    tall: true,
    series: [
      { channel: `residual.${row}`, label: "measured", color: "muted" },
      { channel: `base.${row}`, label: "base", color: "third", dash: [7, 3] },
      { channel: `adapted.${row}`, label: "adapted", color: "estimate" },
      { channel: `foretold.${row}`, label: "foretold", color: "fourth", dash: [2, 2], whenKnown: true },
    ],
  };
}

/** Panel with the forecast from close by. Its channels are those of its numbers. */
function closeUpSpec(row: string, of: string): ChartSpec {
  return {
    key: CLOSE_UP,
    title: `Foresight ${of}`,
    smallestSpan: 0.2,
    zscore: true,
    fan: row,
    series: ["foreseen", "foresight_std", "trust", "lead_s"].map((stem, k) => coloured(`${stem}.${row}`, stem, k)),
  };
}

/** Chart of the error of the forecast at the lead, within the band that holds 90 %. */
function foresightErrorSpec(row: string): ChartSpec {
  const edge = { channel: `foresight_std.${row}`, label: "± 90 %", color: "fourth", whenKnown: true } as const;
  return {
    key: "foresight_error",
    title: `Forecast error at the lead ${symbolOf(row)}`,
    smallestSpan: 0.1,
    zscore: true,
    band: [1, 2],
    series: [
      { channel: `foresight_error.${row}`, label: "error", color: "estimate", whenKnown: true },
      { ...edge, factor: BAND_90 },
      { ...edge, factor: -BAND_90, silent: true },
    ],
  };
}

/** Charts of how the adapter learns. */
function learningSpecs(): ChartSpec[] {
  return [
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
      title: "Covariance",
      logarithmic: true,
      smallestSpan: 1,
      band: [1, 3],
      series: [
        { channel: "covariance_trace", label: "tr Σ", color: "third" },
        { channel: "covariance_eig_max", label: "max", color: "fourth", dash: [6, 3] },
        { channel: "covariance_eig_median", label: "mid", color: "fourth" },
        { channel: "covariance_eig_min", label: "min", color: "fourth", dash: [2, 2] },
      ],
    },
  ];
}

/** Chart of the error of one coordinate and of the position. */
function errorSpec(row: string, title: string): ChartSpec {
  return {
    key: "tracking",
    title,
    smallestSpan: 0.02,
    series: [
      { channel: "position_error_m", label: "position", color: "estimate" },
      { channel: `error.${row}`, label: symbolOf(row), color: "third", dash: [7, 3] },
    ],
  };
}

/** Charts of a mirrored recording: the difference between the vehicle and the twin. */
function mirrorSpecs(row: string): ChartSpec[] {
  return [errorSpec(row, "Divergence from the twin")];
}

/** Charts of the controller. */
function controlSpecs(row: string): ChartSpec[] {
  return [
    errorSpec(row, "Tracking error"),
    foresightErrorSpec(row),
    {
      key: "robust",
      title: "Robust term",
      smallestSpan: 0.1,
      series: [
        { channel: "robust_gain", label: "σ̂", color: "estimate" },
        { channel: "sliding_norm", label: "‖s‖", color: "third", dash: [7, 3] },
      ],
    },
  ];
}

/** Charts with details of the adapter. */
function adapterSpecs(): ChartSpec[] {
  return [
    { key: SPECTRUM, title: "Spectrum of Σ", smallestSpan: 1, series: [] },
    {
      key: "norms",
      title: "Adapter norms",
      logarithmic: true,
      smallestSpan: 0.1,
      series: [
        { channel: "gain_norm", label: "‖K‖", color: "estimate" },
        { channel: "weight_norm", label: "‖W‖", color: "third", dash: [7, 3] },
        { channel: "regime_norm", label: "‖g′‖", color: "fourth", dash: [2, 2] },
      ],
    },
  ];
}

/** Forces of the chart, one colour each. Thrust and weight are so large that no other force would be seen beside them; the picker has all. */
const DRAWN_FORCES = ["payload", "arm", "inflow", "ground", "drag", "wind", "unsteady", "unexplained"];

/** Chart of the forces on the vehicle along one axis of the world; rotations and joints have none. */
function forceSpecs(row: string): ChartSpec[] {
  const series = DRAWN_FORCES.map((force, k) => coloured(`force.${force}.${row}`, force, k));
  return [{ key: "forces", title: `Forces ${symbolOf(row)}, without thrust and weight`, smallestSpan: 0.5, tall: true, series }];
}

/** Charts of the actuators and of the predictor's attention. */
function bodySpecs(channels: ChannelInfo[]): ChartSpec[] {
  const named = (prefix: string): ChannelInfo[] => channels.filter(({ name }) => name.startsWith(prefix));
  const many = (list: ChannelInfo[], label: (channel: ChannelInfo) => string): SeriesSpec[] =>
    list.map((channel, k) => coloured(channel.name, label(channel), k));
  const last = ({ name }: ChannelInfo): string => name.split(".").at(-1) ?? name;
  return [
    { key: "rotors", title: "Rotor thrust", smallestSpan: 1, series: many(named("rotor."), (channel) => channel.label.replace(/^rotor /, "")) },
    { key: "joints", title: "Joint torque", smallestSpan: 0.2, series: many(named("joint_torque."), (channel) => `q${["₀", "₁", "₂", "₃"][Number(last(channel))] ?? last(channel)}`) },
    { key: "attention", title: "Attention", smallestSpan: 0.1, series: many(channels.filter(({ group }) => group === "attention"), ({ label }) => label) },
  ];
}

/** The chart of a demand that the flight did not meet: its signal, and the limits of it. */
export function demandSpec(channels: string[], known: ChannelInfo[], k: number): ChartSpec | null {
  const [signal, ...limits] = channels.flatMap((name) => known.find((channel) => channel.name === name) ?? []);
  if (signal === undefined) return null;
  return {
    key: `demand-${k}`,
    title: `Not kept: ${signal.label.replace(/_(m|rad|n|m_s)$/, "").replaceAll("_", " ")}`,
    smallestSpan: 1e-3,
    tall: true,
    series: [
      { channel: signal.name, label: "found", color: "estimate" },
      ...limits.map(({ name, label }): SeriesSpec => ({ channel: name, label, color: "setpoint", dash: [6, 4] })),
    ],
  };
}

/** The chart that an operator composed, without channels that the flight does not have. */
export function ownSpec(own: OwnChart, channels: ChannelInfo[]): ChartSpec {
  const known = own.channels.flatMap((name) => channels.find((channel) => channel.name === name) ?? []);
  return { key: own.key, title: own.title, smallestSpan: 1e-3, series: known.map((channel, k) => coloured(channel.name, shortName(channel), k)) };
}

/** A short name for the heading of a chart: the label, with the symbol of the coordinate in place of its name. */
function shortName({ label, row }: ChannelInfo): string {
  return row === null ? label : label.replace(new RegExp(`\\b${row}\\b`), symbolOf(row));
}

function coloured(channel: string, label: string, k: number): SeriesSpec {
  const dash = SERIES_DASHES[k % SERIES_DASHES.length];
  return { channel, label, color: k % SERIES_COLORS, ...(dash === undefined ? {} : { dash }) };
}
