// The options of uPlot for a chart of the column: no legend, no pointer handling by uPlot, and ranges from the column.
import uPlot from "uplot";
import { clockSplits } from "./clock";
import type { Bounds } from "./range";
import type { ChartColors } from "./colors";
import type { ChartSpec, SeriesSpec } from "./spec";

const AXIS_FONT = "11px system-ui, DejaVu Sans, sans-serif";
/** Width of the value axis, px. The timeline below the charts leaves the same room. */
export const AXIS_WIDTH_PX = 46;
export const RIGHT_PX = 14;
/** Smallest distance between the labels of the time axis, px. */
export const CLOCK_APART_PX = 64;

/** Smallest distance between the labels of a value axis, px. */
const LABEL_APART_PX = 15;

export interface ChartSource {
  xRange(): Bounds;
  yRange(): Bounds;
  drawBehind(plot: uPlot): void;
  drawOver(plot: uPlot): void;
}

/** Width and height of the plotting area, px. They come from uPlot, so the browser need not compute its layout. */
export function plotSize({ bbox }: uPlot): [number, number] {
  return [bbox.width / uPlot.pxRatio, bbox.height / uPlot.pxRatio];
}

export function colorOf(series: SeriesSpec, colors: ChartColors): string {
  return typeof series.color === "number" ? (colors.series[series.color % colors.series.length] ?? colors.ink) : colors[series.color];
}

export function chartOptions(spec: ChartSpec, series: SeriesSpec[], colors: ChartColors, lineWidth: number, source: ChartSource): uPlot.Options {
  const none = (): null => null;
  const band = bandOf(spec, series);
  return {
    width: 300,
    height: 100,
    padding: [6, RIGHT_PX, 4, 0],
    legend: { show: false },
    cursor: {
      y: false,
      drag: { x: false, y: false },
      points: { show: false },
      bind: { mousedown: none, mouseup: none, click: none, dblclick: none, mousemove: none, mouseenter: none, mouseleave: none },
    },
    scales: {
      x: { time: false, range: () => source.xRange() },
      y: { distr: spec.logarithmic === true ? 3 : 1, range: () => source.yRange() },
    },
    axes: axes(spec, colors, source),
    series: [
      {},
      ...series.map(
        (one): uPlot.Series => ({
          stroke: colorOf(one, colors),
          width: lineWidth,
          points: { show: false },
          ...(one.dash === undefined ? {} : { dash: one.dash }),
          ...(one.stepped === true && uPlot.paths.stepped !== undefined ? { paths: uPlot.paths.stepped({ align: 1 }) } : {}),
        }),
      ),
    ],
    ...(band === null ? {} : { bands: [{ series: band, fill: `color-mix(in srgb, ${colors.fourth} 18%, transparent)` }] }),
    hooks: { drawClear: [(plot) => source.drawBehind(plot)], draw: [(plot) => source.drawOver(plot)] },
  };
}

/** The two lines that bound an area, as uPlot numbers them (x is 0); null if either line is missing. */
function bandOf(spec: ChartSpec, series: SeriesSpec[]): [number, number] | null {
  if (spec.band === undefined || series.length < spec.series.length) return null;
  const [upper, lower] = spec.band;
  return upper < series.length && lower < series.length ? [upper + 1, lower + 1] : null;
}

function axes(spec: ChartSpec, colors: ChartColors, source: ChartSource): uPlot.Axis[] {
  const common = { stroke: colors.muted, font: AXIS_FONT, grid: { stroke: colors.grid, width: 1 }, ticks: { show: false } };
  return [
    {
      ...common,
      size: 0,
      splits: (plot) => clockSplits(source.xRange(), plotSize(plot)[0], CLOCK_APART_PX),
      values: (_, splits) => splits.map(() => ""),
    },
    {
      ...common,
      size: AXIS_WIDTH_PX,
      gap: 4,
      space: 24,
      values: (_, splits) => splits.map((split) => (split === null ? "" : axisText(split))),
      ...(spec.logarithmic === true ? { filter: decadesOnly, grid: { ...common.grid, filter: decadesOnly } } : {}),
    },
  ];
}

/** Keeps the labels at powers of ten on a logarithmic axis, and of these only as many as there is room for. */
function decadesOnly(plot: uPlot, splits: number[]): (number | null)[] {
  const { min, max } = plot.scales["y"] ?? {};
  const decades = Math.max(1, Math.log10((max ?? 10) / (min ?? 1)));
  const every = Math.ceil((decades * LABEL_APART_PX) / Math.max(1, plotSize(plot)[1]));
  return splits.map((split) => {
    const exponent = Math.round(Math.log10(split));
    return Math.abs(Math.log10(split) - exponent) < 1e-9 && exponent % every === 0 ? split : null;
  });
}

function axisText(value: number): string {
  const size = Math.abs(value);
  const text = size !== 0 && (size >= 1e5 || size < 1e-3) ? value.toExponential() : String(Number(value.toPrecision(6)));
  return text.replace("-", "−").replace("e+", "e");
}
