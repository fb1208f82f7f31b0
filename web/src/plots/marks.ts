// Draws behind and over the lines of a chart: stretches with a frozen adapter or lost ticks, marks, limits, and stretches with
// unknown values.
import uPlot from "uplot";
import type { Sample } from "../data/decimate";
import type { ChartColors } from "./colors";
import { type Mark, markKind } from "./clusters";
import type { Frame } from "./frame";
import type { Bounds } from "./range";
import type { Span } from "./view";

const RAIL_PX = 4;
/** A rail is a row of short strokes, so that nobody takes it for a line of data, px. */
const RAIL_STROKES_PX = [2, 4];
/** From this width on a rail says what it means, px. */
const RAIL_NAMED_FROM_PX = 70;
/** Reset lines that are closer together than this are drawn as one, px. */
const LINES_APART_PX = 2;
const ICONS_APART_PX = 12;
const SMALL_FONT = "system-ui, DejaVu Sans, sans-serif";

/** Draws stretches with a frozen adapter (hatched), lost ticks (a solid band) and the range of the statistics. */
export function drawBehind(plot: uPlot, frame: Frame, colors: ChartColors, words: boolean): void {
  const { ctx, bbox } = plot;
  const ratio = uPlot.pxRatio;
  ctx.save();
  if (frame.range !== null) {
    ctx.globalAlpha = 0.16;
    ctx.fillStyle = colors.third;
    band(plot, frame.range, 1);
  }
  ctx.globalAlpha = 0.5;
  const hatch = hatching(ctx, colors.edge, ratio);
  for (const span of frame.frozen) {
    ctx.fillStyle = hatch;
    const width = band(plot, span, 1);
    if (!words || width < 46 * ratio) continue;
    ctx.fillStyle = colors.muted;
    ctx.font = `${11 * ratio}px ${SMALL_FONT}`;
    ctx.textAlign = "left";
    ctx.textBaseline = "bottom";
    ctx.globalAlpha = 1;
    ctx.fillText("frozen", Math.max(bbox.left, plot.valToPos(span[0], "x", true)) + 4 * ratio, bbox.top + bbox.height - 4 * ratio);
    ctx.globalAlpha = 0.5;
  }
  ctx.globalAlpha = 0.35;
  ctx.fillStyle = colors.warn;
  for (const span of frame.gaps) band(plot, span, 2 * ratio);
  ctx.restore();
}

/** Fills `span` over the whole height, at least `least` canvas px wide; returns the visible width, canvas px. */
function band(plot: uPlot, [from, to]: Span, least: number): number {
  const { ctx, bbox } = plot;
  const left = Math.max(bbox.left, plot.valToPos(from, "x", true));
  const right = Math.min(bbox.left + bbox.width, plot.valToPos(to, "x", true));
  if (right < left) return 0;
  ctx.fillRect(left, bbox.top, Math.max(least, right - left), bbox.height);
  return right - left;
}

const hatchings = new Map<string, HTMLCanvasElement>();

function hatching(ctx: CanvasRenderingContext2D, color: string, ratio: number): CanvasPattern | string {
  const name = `${color} ${ratio}`;
  const size = Math.round(7 * ratio);
  let tile = hatchings.get(name);
  if (tile === undefined) {
    tile = Object.assign(document.createElement("canvas"), { width: size, height: size });
    const pen = tile.getContext("2d");
    if (pen === null) return color;
    pen.strokeStyle = color;
    pen.lineWidth = ratio;
    pen.beginPath();
    for (const shift of [-size, 0, size]) {
      pen.moveTo(shift, size);
      pen.lineTo(shift + size, 0);
    }
    pen.stroke();
    hatchings.set(name, tile);
  }
  return ctx.createPattern(tile, "repeat") ?? color;
}

/** Draws a line for every mark in the pattern of its kind, resets with their icon if `resetIcon`, and the begin of a `forecast`. */
export function drawMarks(plot: uPlot, frame: Frame, colors: ChartColors, resetIcon: boolean, forecast: boolean): void {
  const { ctx } = plot;
  const ratio = uPlot.pxRatio;
  ctx.save();
  ctx.lineWidth = ratio;
  for (const mark of frame.marks) {
    if (mark.kind === "reset" || mark.kind === "gap") continue;
    const { dash } = markKind(mark.kind);
    ctx.strokeStyle = markColor(mark, colors);
    ctx.globalAlpha = mark.kind === "phase" || mark.kind === "gain" ? 0.6 : 0.9;
    ctx.setLineDash(dash.map((length) => length * ratio));
    vertical(plot, mark.time, 0);
  }
  ctx.globalAlpha = 1;
  if (forecast && frame.now !== null) {
    ctx.strokeStyle = colors.fourth;
    ctx.setLineDash([]);
    vertical(plot, frame.now, 0);
  }
  ctx.restore();
  drawResets(plot, frame.resets, colors.ink, resetIcon);
}

export function markColor({ kind }: Mark, colors: ChartColors): string {
  const { tone } = markKind(kind);
  if (kind === "marker") return colors.ink;
  return tone === undefined ? colors.muted : colors[tone];
}

/** Draws a vertical line at `time`, `headroom` px below the top; returns false if it is out of view. */
function vertical(plot: uPlot, time: number, headroom: number): boolean {
  const { ctx, bbox } = plot;
  const x = Math.round(plot.valToPos(time, "x", true)) + 0.5;
  if (x < bbox.left || x > bbox.left + bbox.width) return false;
  ctx.beginPath();
  ctx.moveTo(x, bbox.top + headroom);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  return true;
}

/** Draws a dashed line at every reset in view, with its icon if `icon`. */
function drawResets(plot: uPlot, times: number[], color: string, icon: boolean): void {
  const { ctx, bbox } = plot;
  const ratio = uPlot.pxRatio;
  ctx.save();
  ctx.strokeStyle = color;
  ctx.fillStyle = color;
  ctx.lineWidth = ratio;
  ctx.setLineDash([4 * ratio, 3 * ratio]);
  ctx.font = `${13 * ratio}px ${SMALL_FONT}`;
  ctx.textAlign = "center";
  ctx.textBaseline = "top";
  let lineAt = -Infinity;
  let iconAt = -Infinity;
  for (const time of times) {
    const x = plot.valToPos(time, "x", true);
    if (x - lineAt < LINES_APART_PX * ratio) continue;
    lineAt = x;
    const withIcon = icon && x - iconAt >= ICONS_APART_PX * ratio;
    if (!vertical(plot, time, withIcon ? 15 * ratio : 0) || !withIcon) continue;
    iconAt = x;
    ctx.fillText("↺", Math.max(bbox.left + 6 * ratio, x), bbox.top);
  }
  ctx.restore();
}

/** Draws limits as dashed lines in the colour of set-points, each with its name. */
export function drawLimits(plot: uPlot, limits: Bounds[], colors: ChartColors): void {
  const { ctx, bbox } = plot;
  const ratio = uPlot.pxRatio;
  ctx.save();
  ctx.strokeStyle = colors.setpoint;
  ctx.fillStyle = colors.muted;
  ctx.lineWidth = ratio;
  ctx.setLineDash([6 * ratio, 4 * ratio]);
  ctx.font = `${10 * ratio}px ${SMALL_FONT}`;
  ctx.textAlign = "right";
  for (const [value, upper] of limits.flatMap(([low, high]) => [[low, false] as const, [high, true] as const])) {
    const y = Math.round(plot.valToPos(value, "y", true)) + 0.5;
    if (y < bbox.top - 1 || y > bbox.top + bbox.height + 1) continue;
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
    ctx.textBaseline = upper ? "top" : "bottom";
    ctx.fillText(upper ? "max" : "min", bbox.left + bbox.width - 2 * ratio, y + (upper ? 2 : -2) * ratio);
  }
  ctx.restore();
}

/**
 * Draws a dotted rail at the foot of the chart, the `place`-th of `places` from below, where values are unknown for another reason than lost
 * ticks. The uppermost rail has the word.
 */
export function drawUnknown(plot: uPlot, x: number[], values: Sample[], [place, places]: [number, number], color: string, gaps: Span[]): void {
  const { ctx, bbox } = plot;
  const ratio = uPlot.pxRatio;
  const y = bbox.top + bbox.height - (place + 0.5) * RAIL_PX * ratio;
  ctx.save();
  ctx.strokeStyle = color;
  ctx.fillStyle = color;
  ctx.lineWidth = 2 * ratio;
  ctx.setLineDash(RAIL_STROKES_PX.map((length) => length * ratio));
  ctx.font = `${10 * ratio}px ${SMALL_FONT}`;
  ctx.textAlign = "left";
  ctx.textBaseline = "bottom";
  for (const [from, to] of unknownSpans(x, values, gaps)) {
    const left = Math.max(bbox.left, plot.valToPos(from, "x", true));
    const right = Math.min(bbox.left + bbox.width, plot.valToPos(to, "x", true));
    if (right < left) continue;
    ctx.beginPath();
    ctx.moveTo(left, y);
    ctx.lineTo(Math.max(left + 2 * ratio, right), y);
    ctx.stroke();
    if (place === places - 1 && right - left >= RAIL_NAMED_FROM_PX * ratio) ctx.fillText("unknown", left + 3 * ratio, y - 2 * ratio);
  }
  ctx.restore();
}

/** Stretches of x in which `values` are null, each from its first to its last null. Nulls inside `gaps` do not count. */
export function unknownSpans(x: number[], values: Sample[], gaps: Span[] = []): Span[] {
  const spans: Span[] = [];
  let open: Span | null = null;
  values.forEach((value, i) => {
    const time = x[i] ?? NaN;
    const lost = gaps.some(([from, to]) => time >= from && time <= to);
    if (value === null && !lost) {
      if (open === null) spans.push((open = [time, time]));
      else open[1] = time;
    } else if (value !== undefined) {
      open = null;
    }
  });
  return spans;
}
