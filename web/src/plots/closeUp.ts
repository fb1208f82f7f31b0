// The panel with the forecast from close by: the last part of a second, and what is forecast after it. On the shared time axis a
// horizon of a quarter of a second is a few pixels wide. With a cursor the panel shows the forecast that was made there, and what followed.
import type { Store } from "../data/store";
import { element, setText } from "../panels/dom";
import { CanvasPanel } from "./canvasPanel";
import { drawAxes, drawLine } from "./closeUpPen";
import type { ChartColors } from "./colors";
import { BAND_90, extentOf, type Fan, fanOf } from "./fan";
import { drawFan, type Field, leadText } from "./fanPen";
import type { Frame } from "./frame";
import { AXIS_WIDTH_PX, RIGHT_PX } from "./options";
import type { Panel, Picture, SeriesReading } from "./panel";
import { type Bounds, boundsOf, formatValue, linearRange } from "./range";
import type { ChartSpec } from "./spec";

/** Time shown before and after the forecast was made, s. */
const PAST_S = 0.75;
const AHEAD_S = 0.25;
const HEAD_PX = 8;
const FOOT_PX = 15;

export class CloseUp implements Panel {
  readonly over = null;
  visible = true;
  round = -1;
  private readonly panel: CanvasPanel;
  private readonly outputs = { forecast: element("output", { ariaLive: "off", className: "wide" }), trust: element("output", { ariaLive: "off" }) };
  private range: Bounds | null = null;
  private frame: Frame | null = null;
  private tick = NaN;
  private zscore = false;

  /** `row` is the coordinate. */
  constructor(
    readonly spec: ChartSpec,
    private readonly row: string,
    private readonly store: Store,
    private readonly colors: ChartColors,
    private readonly lineWidth: number,
  ) {
    const others = "the other lines are those of the residual: adapted forecast, and forecast made one lead ago";
    const entries = [
      { label: "measured", title: others, color: colors.muted },
      { label: "lead", title: "forecast at the lead, and half the width of the band that holds 90 %", color: colors.fourth, output: this.outputs.forecast },
      { label: "trust", title: "1: the forecast at the lead is compensated, 0: the estimate of now", output: this.outputs.trust },
    ];
    this.panel = new CanvasPanel(spec, "tall", entries, () => (this.round = -1));
  }

  get root(): HTMLElement {
    return this.panel.root;
  }

  refresh(frame: Frame): void {
    this.frame = frame;
    if (frame.zscore !== this.zscore) this.range = null;
    this.zscore = frame.zscore;
    this.tick = NaN;
  }

  point(time: number | null): void {
    const tick = time === null ? (this.frame?.newest ?? NaN) : Math.min(this.store.tickAt(time), this.store.history.last);
    if (Object.is(tick, this.tick)) return;
    this.tick = tick;
    this.draw();
  }

  write(): void {
    const fan = this.fan();
    const half = this.at("foresight_std") * BAND_90;
    setText(this.outputs.forecast, `${formatValue(this.at("foreseen"))} ± ${formatValue(half)}`);
    setText(this.outputs.trust, formatValue(this.store.at(`trust.${this.row}`, this.tick)));
    const scored = this.scale() !== 1;
    setText(this.panel.unit, scored ? " z" : ` ${this.store.channel(`residual.${this.row}`)?.unit ?? ""}`);
    this.root.ariaLabel = `${this.sentence()}, ${leadText(fan?.leadS ?? 0)}`;
  }

  select(): void {}

  readings(): SeriesReading[] {
    return (this.fan()?.points ?? []).map(({ time, value, half }) => ({
      channel: `fan at ${time.toFixed(3)} s`,
      label: `${time.toFixed(3)} s`,
      value,
      plotted: [value - (half ?? 0), value + (half ?? 0)],
      breaks: 0,
    }));
  }

  sentence(): string {
    return `${this.spec.title}: at the lead ${formatValue(this.at("foreseen"))}, trust ${formatValue(this.store.at(`trust.${this.row}`, this.tick))}`;
  }

  picture(): Picture {
    const entry = (label: string, output: HTMLElement): Picture["entries"][number] => ({ label, text: output.textContent ?? "", color: this.colors.fourth, dash: [] });
    return { title: this.spec.title, entries: [entry("lead", this.outputs.forecast), entry("trust", this.outputs.trust)], canvas: this.panel.canvas };
  }

  destroy(): void {
    this.panel.destroy();
  }

  private fan(): Fan | null {
    return fanOf(this.store, this.row, this.tick, this.scale());
  }

  private at(stem: string): number {
    return this.store.withoutWeight(`${stem}.${this.row}`, this.tick) * this.scale();
  }

  private scale(): number {
    const z = this.store.channel(`residual.${this.row}`)?.z_scale ?? null;
    return this.zscore && z !== null ? 1 / z : 1;
  }

  /** Values of a channel from `from` to `to` seconds after the forecast was made, up to the newest tick of the frame. */
  private values(stem: string, from: number, to: number): number[] {
    const [first, last] = [from, to].map((seconds) => this.tick + Math.round(seconds / this.store.tickS)) as [number, number];
    const name = `${stem}.${this.row}`;
    const end = Math.min(last, this.frame?.newest ?? last);
    return Array.from({ length: Math.max(0, end - first + 1) }, (_, k) => this.store.withoutWeight(name, first + k) * this.scale());
  }

  private draw(): void {
    const pen = this.panel.pen();
    if (pen === null || Number.isNaN(this.tick)) return;
    const [width, height] = this.panel.size;
    const fan = this.fan();
    const shown = ["residual", "foretold", "adapted"].flatMap((stem) => this.values(stem, -PAST_S, AHEAD_S)).filter((value) => !Number.isNaN(value));
    this.range = linearRange(this.range, boundsOf([shown, extentOf(fan)], false), this.spec.smallestSpan);
    const field = this.field(pen, width, height);
    const now = this.store.timeOf(this.tick);
    drawAxes(field, this.colors, this.range, now, AHEAD_S, PAST_S);
    const line = (stem: string, color: string, dash: number[], to: number): void =>
      drawLine(field, this.values(stem, -PAST_S, to), now - PAST_S, this.store.tickS, { color, dash, width: this.lineWidth });
    line("residual", this.colors.muted, [], AHEAD_S);
    line("foretold", this.colors.fourth, [2, 2], 0);
    line("adapted", this.colors.estimate, [], 0);
    if (fan !== null) drawFan(field, fan, this.colors, this.lineWidth);
  }

  private field(pen: CanvasRenderingContext2D, width: number, height: number): Field {
    const [low, high] = this.range ?? [0, 1];
    const [left, top, wide, tall] = [AXIS_WIDTH_PX, HEAD_PX, Math.max(1, width - AXIS_WIDTH_PX - RIGHT_PX), Math.max(1, height - HEAD_PX - FOOT_PX)];
    const begin = this.store.timeOf(this.tick) - PAST_S;
    return {
      pen, left, top, width: wide, height: tall, ratio: 1,
      xOf: (time) => left + ((time - begin) / (PAST_S + AHEAD_S)) * wide,
      yOf: (value) => top + (1 - (value - low) / (high - low)) * tall,
    };
  }
}
