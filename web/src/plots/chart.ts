// One chart: the plot, and a heading with the values at the cursor or the newest ones.
import uPlot from "uplot";
import { decimate, type Sample, type Trace } from "../data/decimate";
import type { Store } from "../data/store";
import { element, setText } from "../panels/dom";
import type { ChannelInfo } from "../protocol";
import type { ChartColors } from "./colors";
import { extentOf, type Fan, fanOf } from "./fan";
import { drawFan, type Field } from "./fanPen";
import { drawForks, type ForkLine, forkLines } from "./forkPen";
import type { Frame } from "./frame";
import { drawBehind, drawLimits, drawMarks, drawUnknown } from "./marks";
import { chartOptions, colorOf, plotSize } from "./options";
import type { Panel, Picture, SeriesReading } from "./panel";
import { boundsOf, type Bounds, decadeRange, formatValue, linearRange } from "./range";
import { showing } from "./software";
import type { ChartSpec, SeriesSpec } from "./spec";
import type { Span } from "./view";

/** The least time between two updates of the chart's text for screen readers, ms. */
const SPEAK_EVERY_MS = 2000;

export class Chart implements Panel {
  readonly root: HTMLElement;
  visible = true;
  round = -1;
  private readonly plot: uPlot;
  private readonly outputs: HTMLOutputElement[];
  private readonly series: SeriesSpec[];
  private readonly channels: ChannelInfo[];
  private readonly limits: Bounds[];
  private readonly unit = element("span", { className: "muted" });
  private readonly sizes: ResizeObserver;
  private yRange: Bounds | null = null;
  private x: number[] = [];
  private values: Sample[][] = [];
  private frame: Frame | null = null;
  private traces: Trace[] = [];
  private spokenAt = -Infinity;
  private zscore = false;
  /** Which series are shown: all but those that wait for their first known value. */
  private readonly shown: boolean[];
  private forks: ForkLine[] = [];
  private fan: Fan | null = null;
  /** Tick at which the fan begins. */
  private fanTick = NaN;

  /** `tools` are controls that the heading has beside the title. */
  constructor(
    readonly spec: ChartSpec,
    private readonly store: Store,
    private readonly colors: ChartColors,
    private readonly lineWidth: number,
    tools: Node[],
  ) {
    this.series = spec.series.filter(({ channel }) => store.channel(channel) !== undefined);
    this.channels = this.series.flatMap(({ channel }) => store.channel(channel) ?? []);
    this.limits = distinct(this.channels.flatMap(({ limits }) => (limits === null ? [] : [limits])));
    this.shown = this.series.map(({ whenKnown }) => whenKnown !== true);
    this.outputs = this.series.map(() => element("output", { ariaLive: "off" }));
    const plotRoot = element("div", { className: "plot" });
    this.root = element("article", { className: spec.tall === true ? "chart tall" : "chart", ariaLabel: spec.title, tabIndex: 0, role: "figure" }, [this.heading(tools), plotRoot]);
    this.root.dataset["key"] = spec.key;
    const source = {
      xRange: (): Bounds => this.frame?.span ?? [0, 1],
      yRange: (): Bounds => this.yRange ?? [0.1, 1],
      drawBehind: (plot: uPlot) => this.frame !== null && drawBehind(plot, this.frame, colors, spec.resetIcon === true),
      drawOver: (plot: uPlot) => this.drawOver(plot),
    };
    const options = chartOptions(spec, this.series, colors, lineWidth, source);
    this.plot = showing(() => new uPlot(options, [[], ...this.series.map(() => [])], plotRoot));
    this.sizes = new ResizeObserver(() => this.plot.setSize({ width: plotRoot.clientWidth, height: plotRoot.clientHeight }));
    this.sizes.observe(plotRoot);
  }

  get over(): HTMLElement {
    return this.plot.over;
  }

  refresh(frame: Frame): void {
    this.frame = frame;
    if (frame.zscore !== this.zscore) this.yRange = null;
    this.zscore = frame.zscore;
    this.traces = this.series.map((series, k) => ({
      column: this.store.index(series.channel) ?? -1,
      less: this.channels[k]?.weight ?? 0,
      scale: this.scale(k),
    }));
    const out = decimate(this.store.history, this.traces, frame.ticks[0], frame.ticks[1], frame.bucket, this.store.timeOf);
    this.x = out.x;
    this.values = this.spec.logarithmic === true ? out.series.map(positive) : out.series;
    this.forks = this.forkLines(frame);
    this.fanAt(this.fanTick);
    this.fit();
    this.showKnown();
    this.showUnit();
    this.plot.setData([this.x, ...this.values] as uPlot.AlignedData);
  }

  /** Puts the cursor at `time`; null hides it. */
  point(time: number | null): void {
    if (this.frame === null) return;
    const [from, to] = this.frame.span;
    const left = time === null || time < from || time > to ? -10 : ((time - from) / (to - from)) * plotSize(this.plot)[0];
    this.plot.setCursor({ left, top: left < 0 ? -10 : 1 }, false);
    const tick = time === null ? this.frame.newest : Math.min(this.store.tickAt(time), this.store.history.last);
    if (this.spec.fan === undefined || tick === this.fanTick) return;
    this.fanAt(tick);
    this.plot.redraw(false);
  }

  /** Shows the values at `time`; for null the newest values. */
  write(time: number | null, now: number): void {
    this.outputs.forEach((output, k) => setText(output, formatValue(this.valueAt(k, time))));
    if (now - this.spokenAt < SPEAK_EVERY_MS) return;
    this.spokenAt = now;
    this.root.ariaLabel = this.sentence(time);
  }

  /** Marks the stretch between two positions, as parts of the width, as selected; null removes the mark. */
  select(part: [number, number] | null): void {
    const [width, height] = plotSize(this.plot);
    const [from, to] = part ?? [0, 0];
    this.plot.setSelect({ left: from * width, width: (to - from) * width, top: 0, height: part === null ? 0 : height }, false);
  }

  readings(time: number | null): SeriesReading[] {
    return this.series.map(({ channel, label }, k) => ({
      channel,
      label,
      value: this.valueAt(k, time),
      plotted: boundsOf([this.values[k] ?? []], false),
      breaks: (this.values[k] ?? []).filter((value) => value === null).length,
    }));
  }

  /** One sentence with the values at `time`; for null with the newest values. */
  sentence(time: number | null): string {
    const values = this.series.flatMap(({ label, silent }, k) => {
      const value = this.valueAt(k, time);
      return silent === true ? [] : `${label} ${Number.isNaN(value) ? "unknown" : formatValue(value)} ${this.unitOf(k)}`.trim();
    });
    return `${this.spec.title}: ${values.join(", ")}`;
  }

  picture(): Picture {
    return {
      title: `${this.spec.title}${this.unit.textContent ?? ""}`,
      entries: this.series.flatMap((series, k) => (series.silent === true ? [] : [{ label: series.label, text: this.outputs[k]?.textContent ?? "", color: colorOf(series, this.colors), dash: series.dash ?? [] }])),
      canvas: this.plot.ctx.canvas,
    };
  }

  destroy(): void {
    this.sizes.disconnect();
    this.plot.destroy();
    this.root.remove();
  }

  /** Value of a series at `time`; for null at the newest tick of the frame. */
  private valueAt(k: number, time: number | null): number {
    const newest = this.frame?.newest ?? this.store.history.last;
    const tick = time === null ? newest : this.store.tickAt(time);
    return this.store.withoutWeight(this.series[k]?.channel ?? "", tick) * this.scale(k);
  }

  private drawOver(plot: uPlot): void {
    if (this.frame === null) return;
    drawForks(fieldOf(plot), this.forks, this.colors, this.lineWidth);
    if (this.limits.length > 0) drawLimits(plot, this.limits, this.colors);
    const lost = this.lost();
    const railed = this.series.map((series, k) => ({ series, k })).filter(({ series, k }) => this.shown[k] === true && series.silent !== true && (this.values[k] ?? []).includes(null));
    railed.forEach(({ series, k }, place) => drawUnknown(plot, this.x, this.values[k] ?? [], [place, railed.length], colorOf(series, this.colors), lost));
    const fanned = this.fan !== null && this.fan.points.length > 1;
    drawMarks(plot, this.frame, this.colors, this.spec.resetIcon === true, fanned);
    if (this.fan !== null && fanned) drawFan(fieldOf(plot), this.fan, this.colors, this.lineWidth);
  }

  /** Stretches in which a series has no values because its ticks were lost, s. */
  private lost(): Span[] {
    const bucket = (this.frame?.bucket ?? 1) * this.store.tickS;
    return (this.frame?.gaps ?? []).map(([from, to]): Span => [from - bucket, to + bucket]);
  }

  private fit(): void {
    const logarithmic = this.spec.logarithmic === true;
    const forks = this.forks.map(({ points }) => points.map(([, value]) => value));
    const bounds = boundsOf([...this.values, ...this.limits, extentOf(this.fan), ...forks], logarithmic);
    this.yRange = logarithmic ? decadeRange(this.yRange, bounds) : linearRange(this.yRange, bounds, this.spec.smallestSpan);
  }

  /** The lines of the forks: each shows the first series of the chart. */
  private forkLines(frame: Frame): ForkLine[] {
    const k = this.series.findIndex(({ silent }) => silent !== true);
    const column = k < 0 ? undefined : this.store.index(this.series[k]?.channel ?? "");
    return column === undefined ? [] : forkLines(this.store, column, this.scale(k), frame, this.spec.logarithmic === true);
  }

  private fanAt(tick: number): void {
    this.fanTick = tick;
    this.fan = this.spec.fan === undefined ? null : fanOf(this.store, this.spec.fan, tick, this.unitScale(0));
  }

  /** Factor by which the values of a series are multiplied. */
  private scale(k: number): number {
    return this.unitScale(k) * (this.series[k]?.factor ?? 1);
  }

  /** One over the scale of a series if z-scores are shown, else 1. */
  private unitScale(k: number): number {
    const z = this.channels[k]?.z_scale;
    return this.spec.zscore === true && this.frame?.zscore === true && z !== null && z !== undefined ? 1 / z : 1;
  }

  /** Shows a series in the legend as soon as it has a value. */
  private showKnown(): void {
    this.outputs.forEach(({ parentElement: entry }, k) => {
      if (this.shown[k] !== true) this.shown[k] = (this.values[k] ?? []).some((value) => typeof value === "number");
      if (entry !== null) entry.hidden = this.shown[k] !== true || this.series[k]?.silent === true;
    });
  }

  private unitOf(k: number): string {
    return this.unitScale(k) === 1 ? (this.channels[k]?.unit ?? "") : "";
  }

  private showUnit(): void {
    const scored = this.series.some((_, k) => this.unitScale(k) !== 1);
    const units = [...new Set(this.channels.map(({ unit }) => unit))].filter((unit) => unit !== "");
    setText(this.unit, scored ? " z" : units.length === 0 ? "" : ` ${units.join(", ")}`);
  }

  private heading(tools: Node[]): HTMLElement {
    this.showUnit();
    const key = this.series.map((series, k) => {
      const line = element("i", { className: series.dash === undefined ? "line" : "line dashed" });
      line.style.color = colorOf(series, this.colors);
      const output = this.outputs[k];
      return element("li", { title: `${this.channels[k]?.label ?? ""} (${series.channel})` }, [line, series.label, ...(output === undefined ? [] : [output])]);
    });
    return element("header", { className: "chart-head" }, [element("h3", { title: this.spec.title }, [this.spec.title, this.unit]), ...tools, element("ul", {}, key)]);
  }
}

function distinct(limits: Bounds[]): Bounds[] {
  return limits.filter(([low, high], index) => limits.findIndex((other) => other[0] === low && other[1] === high) === index);
}

/** The plotting area in pixels of the canvas. */
function fieldOf(plot: uPlot): Field {
  const { ctx: pen, bbox } = plot;
  return { pen, ...bbox, ratio: uPlot.pxRatio, xOf: (time) => plot.valToPos(time, "x", true), yOf: (value) => plot.valToPos(value, "y", true) };
}

/** Removes points that a logarithmic axis cannot show. They are known values, so they are not marked as unknown. */
function positive(values: Sample[]): Sample[] {
  return values.map((value) => (typeof value === "number" && value <= 0 ? undefined : value));
}
