// The panel with the errors of the forecasts of all coordinates at a glance: one small field each, all with the same scale, in z-scores. A
// click on a field chooses its coordinate for the charts.
import type { Sample } from "../data/decimate";
import type { Store } from "../data/store";
import { element, setText } from "../panels/dom";
import { CanvasPanel } from "./canvasPanel";
import type { ChartColors } from "./colors";
import type { Frame } from "./frame";
import { AXIS_WIDTH_PX, RIGHT_PX } from "./options";
import type { Panel, Picture, SeriesReading } from "./panel";
import { type Bounds, boundsOf, formatValue, linearRange } from "./range";
import { type ChartSpec, symbolOf } from "./spec";

/** Fields in one line of the panel. */
const ACROSS = 4;
const GAP_PX = 4;
const FONT = "11px system-ui, DejaVu Sans, sans-serif";
/** Points of a line: a field is a few hundred pixels wide at most. */
const POINTS = 160;
/** Smallest span of the shared scale, z-scores, so that noise does not fill the fields. */
const SMALLEST_SPAN = 0.5;

interface Lines {
  row: string;
  /** Scale of the z-scores. */
  scale: number;
  base: Sample[];
  adapted: Sample[];
}

export class Multiples implements Panel {
  readonly over = null;
  visible = true;
  round = -1;
  private readonly panel: CanvasPanel;
  private readonly most = element("output", { ariaLive: "off", className: "wide" });
  private range: Bounds | null = null;
  private lines: Lines[] = [];
  private x: number[] = [];
  private frame: Frame | null = null;
  private cursor: number | null = null;

  /** `chosen` is the coordinate of the other charts; `choose` is called with the coordinate of a clicked field. */
  constructor(
    readonly spec: ChartSpec,
    private readonly store: Store,
    private readonly colors: ChartColors,
    private readonly chosen: () => string,
    choose: (row: string) => void,
  ) {
    const entries = [
      { label: "base", title: "measured − base forecast", color: colors.third },
      { label: "adapted", title: "measured − adapted forecast", color: colors.estimate },
      { label: "largest", title: "coordinate with the largest error of the adapted forecast at this moment", output: this.most },
    ];
    this.panel = new CanvasPanel(spec, "tall", entries, () => (this.round = -1));
    setText(this.panel.unit, " z, same scale");
    this.panel.canvas.addEventListener("click", ({ offsetX, offsetY }) => {
      const row = this.lines.find((_, k) => inside(this.field(k), offsetX, offsetY))?.row;
      if (row !== undefined) choose(row);
    });
    this.panel.canvas.style.cursor = "pointer";
  }

  get root(): HTMLElement {
    return this.panel.root;
  }

  refresh(frame: Frame): void {
    this.frame = frame;
    this.lines = this.store.rows().flatMap((row) => this.linesOf(row, frame) ?? []);
    this.range = linearRange(this.range, boundsOf([...this.lines.flatMap(({ base, adapted }) => [base, adapted]), [0]], false), SMALLEST_SPAN);
    this.draw();
  }

  point(time: number | null): void {
    if (time === this.cursor) return;
    this.cursor = time;
    this.draw();
  }

  write(): void {
    const worst = this.worst();
    setText(this.most, worst === null ? "unknown" : `${symbolOf(worst.row)} ${formatValue(worst.value)}`);
    this.root.ariaLabel = this.sentence();
  }

  select(): void {}

  readings(time: number | null): SeriesReading[] {
    const tick = time === null ? this.store.shownTick : this.store.tickAt(time);
    return this.lines.flatMap(({ row, scale, base, adapted }) =>
      Object.entries({ base, adapted }).map(([stem, values]) => ({
        channel: `error of ${stem}.${row}`,
        label: row,
        value: this.error(stem, row, tick, scale),
        plotted: boundsOf([values], false),
        breaks: values.filter((value) => value === null).length,
      })),
    );
  }

  sentence(): string {
    const worst = this.worst();
    return `${this.spec.title}: ${worst === null ? "unknown" : `largest for ${symbolOf(worst.row)}, ${formatValue(worst.value)}`}`;
  }

  picture(): Picture {
    return { title: this.spec.title, entries: [{ label: "largest", text: this.most.textContent ?? "", color: this.colors.estimate, dash: [] }], canvas: this.panel.canvas };
  }

  destroy(): void {
    this.panel.destroy();
  }

  /** Coordinate with the largest error of the adapted forecast at the cursor, else at the shown moment. */
  private worst(): { row: string; value: number } | null {
    const tick = this.cursor === null ? this.store.shownTick : this.store.tickAt(this.cursor);
    const found = this.lines.map(({ row, scale }) => ({ row, value: Math.abs(this.error("adapted", row, tick, scale)) }));
    return found.filter(({ value }) => !Number.isNaN(value)).sort((a, b) => b.value - a.value)[0] ?? null;
  }

  private linesOf(row: string, frame: Frame): Lines | null {
    const scale = this.store.channel(`residual.${row}`)?.z_scale ?? null;
    if (scale === null) return null;
    const [first, end] = frame.ticks;
    const every = Math.max(1, Math.ceil((end - first) / POINTS));
    const start = Math.ceil(first / every) * every;
    const ticks = Array.from({ length: Math.max(0, Math.ceil((end - start) / every)) }, (_, k) => start + k * every);
    this.x = ticks.map(this.store.timeOf);
    const value = (stem: string, tick: number): Sample => {
      const error = this.error(stem, row, tick, scale);
      return Number.isNaN(error) ? null : error;
    };
    return { row, scale, base: ticks.map((tick) => value("base", tick)), adapted: ticks.map((tick) => value("adapted", tick)) };
  }

  private error(stem: string, row: string, tick: number, scale: number): number {
    return (this.store.at(`residual.${row}`, tick) - this.store.at(`${stem}.${row}`, tick)) / scale;
  }

  private field(k: number): { left: number; top: number; width: number; height: number } {
    const [width, height] = this.panel.size;
    const lines = Math.max(1, Math.ceil(this.lines.length / ACROSS));
    const [w, h] = [(width - AXIS_WIDTH_PX - RIGHT_PX + GAP_PX) / ACROSS, height / lines];
    return { left: AXIS_WIDTH_PX + (k % ACROSS) * w, top: Math.floor(k / ACROSS) * h + 1, width: w - GAP_PX, height: h - GAP_PX };
  }

  private draw(): void {
    const pen = this.panel.pen();
    if (pen === null || this.frame === null || this.range === null) return;
    const [low, high] = this.range;
    pen.font = FONT;
    pen.textBaseline = "top";
    this.lines.forEach(({ row, base, adapted }, k) => {
      const { left, top, width, height } = this.field(k);
      const yOf = (value: number): number => top + (1 - (value - low) / (high - low)) * height;
      pen.strokeStyle = row === this.chosen() ? this.colors.ink : this.colors.grid;
      pen.lineWidth = 1;
      pen.strokeRect(Math.round(left) + 0.5, Math.round(top) + 0.5, width, height);
      pen.strokeStyle = this.colors.edge;
      line(pen, [left, left + width], [0, 0], (x) => x, yOf);
      const xOf = (time: number): number => this.xOf(time, left, width);
      pen.setLineDash([4, 2]);
      pen.strokeStyle = this.colors.third;
      line(pen, this.x, base, xOf, yOf);
      pen.setLineDash([]);
      pen.strokeStyle = this.colors.estimate;
      line(pen, this.x, adapted, xOf, yOf);
      if (this.cursor !== null) {
        pen.fillStyle = this.colors.ink;
        pen.fillRect(Math.round(xOf(this.cursor)), top, 1, height);
      }
      pen.fillStyle = this.colors.ink;
      pen.textAlign = "left";
      pen.fillText(symbolOf(row), left + 4, top + 3);
    });
    pen.fillStyle = this.colors.muted;
    pen.textAlign = "right";
    const { top, height } = this.field(0);
    pen.fillText(formatValue(high), AXIS_WIDTH_PX - 5, top);
    pen.textBaseline = "bottom";
    pen.fillText(formatValue(low), AXIS_WIDTH_PX - 5, top + height);
  }

  private xOf(time: number, left: number, width: number): number {
    const [from, to] = this.frame?.span ?? [0, 1];
    return left + Math.min(1, Math.max(0, (time - from) / (to - from))) * width;
  }
}

function inside({ left, top, width, height }: { left: number; top: number; width: number; height: number }, x: number, y: number): boolean {
  return x >= left && x <= left + width && y >= top && y <= top + height;
}

/** Draws a line; unknown values break it. */
function line(pen: CanvasRenderingContext2D, x: number[], values: Sample[], xOf: (x: number) => number, yOf: (value: number) => number): void {
  pen.beginPath();
  let open = false;
  values.forEach((value, k) => {
    const known = typeof value === "number";
    if (known) pen[open ? "lineTo" : "moveTo"](xOf(x[k] ?? 0), yOf(value));
    open = known;
  });
  pen.stroke();
}
