// One chart: a heading with the newest (or pointed-at) values, and the plot.
import uPlot from "uplot";
import { decimate, type Sample } from "../data/decimate";
import { lowerBound } from "../data/ring";
import type { Store } from "../data/store";
import { element } from "../panels/dom";
import type { Palette } from "../panels/theme";
import { drawResets, drawUnknown } from "./marks";
import { boundsOf, type Bounds, decadeRange, formatValue, linearRange } from "./range";
import type { ChartSpec, SeriesSpec } from "./spec";

export interface ChartStyle {
  palette: Palette;
  lineWidth: number;
  /** The last chart of the column carries the labels of the shared clock. */
  clock: boolean;
}

const AXIS_FONT = "11px system-ui, DejaVu Sans, sans-serif";
const AXIS_WIDTH_PX = 46;
const CLOCK_HEIGHT_PX = 22;

export class Chart {
  readonly root: HTMLElement;
  /** Not on the screen: not worth drawing. */
  visible = true;
  drawnAt = -Infinity;
  drawnTick = NaN;
  private readonly plot: uPlot;
  private readonly outputs: HTMLOutputElement[];
  private readonly series: SeriesSpec[];
  private xRange: Bounds = [0, 1];
  private yRange: Bounds | null = null;
  private x: number[] = [];
  private values: Sample[][] = [];
  private resets: number[] = [];

  constructor(
    private readonly spec: ChartSpec,
    private readonly store: Store,
    private readonly style: ChartStyle,
  ) {
    this.series = spec.series.filter(({ channel }) => store.channel(channel) !== undefined);
    this.outputs = this.series.map(() => element("output", { ariaLive: "off" }));
    const plotRoot = element("div", { className: "plot" });
    this.root = element("article", { className: "chart", ariaLabel: spec.title }, [this.heading(), plotRoot]);
    this.plot = new uPlot(this.options(), [[], ...this.series.map(() => [])], plotRoot);
    new ResizeObserver(() => this.plot.setSize({ width: plotRoot.clientWidth, height: plotRoot.clientHeight })).observe(plotRoot);
  }

  /** Draws the stretch of history that ends at `to`, s. */
  refresh(from: number, to: number, ticksPerBucket: number): void {
    const { ring, timeOf } = this.store;
    const stamps = ring.stampView();
    const columns = this.series.map(({ channel }) => this.store.column(channel) ?? new Float32Array());
    const tickS = this.store.hello?.tick_s ?? 0.01;
    const first = Math.max(0, lowerBound(stamps, from / tickS - 1) - 1);
    const out = decimate(stamps, columns, first, stamps.length, ticksPerBucket, timeOf);
    this.x = out.x;
    this.values = this.spec.logarithmic === true ? out.series.map(positive) : out.series;
    this.xRange = [from, to];
    const bounds = boundsOf(this.values, this.spec.logarithmic === true);
    this.yRange = this.spec.logarithmic === true ? decadeRange(this.yRange, bounds) : linearRange(this.yRange, bounds, this.spec.smallestSpan);
    this.resets = this.store.resets.map(timeOf).filter((time) => time >= from);
    this.plot.setData([this.x, ...this.values] as uPlot.AlignedData);
    this.showValues();
  }

  /** What is drawn is no longer right, whatever the tick. */
  expire(): void {
    this.drawnAt = -Infinity;
    this.drawnTick = NaN;
  }

  destroy(): void {
    this.plot.destroy();
    this.root.remove();
  }

  private heading(): HTMLElement {
    const units = [...new Set(this.series.map(({ channel }) => this.store.channel(channel)?.unit ?? ""))].filter((unit) => unit !== "");
    const unit = element("span", { className: "muted", textContent: units.length === 0 ? "" : ` ${units.join(", ")}` });
    const key = this.series.map((series, k) => {
      const line = element("i", { className: series.dash === undefined ? "line" : "line dashed" });
      line.style.color = this.style.palette[series.color];
      const output = this.outputs[k];
      return element("li", { title: this.store.channel(series.channel)?.label ?? "" }, [line, series.label, ...(output === undefined ? [] : [output])]);
    });
    return element("header", { className: "chart-head" }, [element("h3", { title: this.spec.title }, [this.spec.title, unit]), element("ul", {}, key)]);
  }

  /** Values under the pointer while there is one, else the newest. */
  private showValues(): void {
    const left = this.plot.cursor.left ?? -1;
    const index = left >= 0 && this.x.length > 0 ? this.plot.posToIdx(left) : -1;
    this.outputs.forEach((output, k) => {
      const series = this.series[k];
      const value = index >= 0 ? this.values[k]?.[index] : this.store.latest(series?.channel ?? "");
      const text = formatValue(value);
      if (output.textContent !== text) output.textContent = text;
    });
  }

  private options(): uPlot.Options {
    const { palette, lineWidth } = this.style;
    return {
      width: 300,
      height: 100,
      padding: [6, 16, 2, 0],
      legend: { show: false },
      cursor: { y: false, sync: { key: "twin", scales: ["x", null] }, drag: { x: false, y: false }, points: { show: false } },
      scales: {
        x: { time: false, range: () => this.xRange },
        y: { distr: this.spec.logarithmic === true ? 3 : 1, range: () => this.yRange ?? [0.1, 1] },
      },
      axes: this.axes(),
      series: [
        {},
        ...this.series.map(
          (series): uPlot.Series => ({
            stroke: palette[series.color],
            width: lineWidth,
            points: { show: false },
            ...(series.dash === undefined ? {} : { dash: series.dash }),
            ...(series.stepped === true && uPlot.paths.stepped !== undefined ? { paths: uPlot.paths.stepped({ align: 1 }) } : {}),
          }),
        ),
      ],
      hooks: {
        setCursor: [() => this.showValues()],
        draw: [
          (plot) => drawUnknown(plot, this.x, this.values, this.series.map((series) => palette[series.color])),
          (plot) => drawResets(plot, this.resets, palette.ink, this.spec.resetIcon === true),
        ],
      },
    };
  }

  private axes(): uPlot.Axis[] {
    const { palette, clock } = this.style;
    const common = {
      stroke: palette.muted,
      font: AXIS_FONT,
      grid: { stroke: palette.grid, width: 1 },
      ticks: { show: false },
    };
    return [
      {
        ...common,
        size: clock ? CLOCK_HEIGHT_PX : 2,
        gap: 3,
        space: 60,
        values: (_, splits) => (clock ? splits.map((split) => `${Number(split.toFixed(3))} s`) : splits.map(() => "")),
      },
      {
        ...common,
        size: AXIS_WIDTH_PX,
        gap: 4,
        space: 24,
        values: (_, splits) => splits.map((split) => (split === null ? "" : axisText(split))),
        ...(this.spec.logarithmic === true ? { filter: decadesOnly, grid: { ...common.grid, filter: decadesOnly } } : {}),
      },
    ];
  }
}

/** Only powers of ten are labelled on a logarithmic axis. */
function decadesOnly(_: uPlot, splits: number[]): (number | null)[] {
  return splits.map((split) => (Math.abs(Math.log10(split) - Math.round(Math.log10(split))) < 1e-9 ? split : null));
}

function axisText(value: number): string {
  const size = Math.abs(value);
  const text = size !== 0 && (size >= 1e5 || size < 1e-3) ? value.toExponential() : String(Number(value.toPrecision(6)));
  return text.replace("-", "−").replace("e+", "e");
}

/** A logarithm has no place for zero, yet zero is a value: no point there, and no mark for an unknown one. */
function positive(values: Sample[]): Sample[] {
  return values.map((value) => (typeof value === "number" && value <= 0 ? undefined : value));
}
