// Draws the lanes of the timeline. Text and glyphs say everything; colour repeats it.
import { clusters, markKind } from "../plots/clusters";
import { clockSplits, clockText } from "../plots/clock";
import type { ChartColors } from "../plots/colors";
import { markColor } from "../plots/marks";
import { type Lanes, MARK_LANES } from "./lanes";

/** Heights of the lanes, px, from above: phases, marks (each), ribbon, clock. */
const PHASE_PX = 16;
const MARK_PX = 13;
const RIBBON_PX = 14;
const CLOCK_PX = 14;
const GAP_PX = 1;
/** Height of all lanes, px. */
export const LANES_PX = PHASE_PX + MARK_LANES.length * (MARK_PX + GAP_PX) + RIBBON_PX + CLOCK_PX + 2 * GAP_PX;
/** Width of the names of the lanes, px. */
export const NAMES_PX = 62;
export const RIGHT_PX = 10;
const GLYPHS_APART_PX = 12;
const CLOCK_APART_PX = 74;
const FONT = "11px system-ui, DejaVu Sans, sans-serif";
const GLYPH_FONT = "12px system-ui, DejaVu Sans, sans-serif";
/** The ribbon is full at this share of δ, so that a reset, at 1, stands out below its edge. */
const RIBBON_FULL = 1.25;
/** From this share of δ on the adapter is near a reset. */
const NEAR = 0.7;

export function drawLanes(pen: CanvasRenderingContext2D, lanes: Lanes, width: number, colors: ChartColors): void {
  const plot = Math.max(1, width - NAMES_PX - RIGHT_PX);
  const xOf = (time: number): number => NAMES_PX + ((time - lanes.span[0]) / (lanes.span[1] - lanes.span[0])) * plot;
  pen.font = FONT;
  pen.textBaseline = "middle";
  let top = 0;
  name(pen, "phase", top + PHASE_PX / 2, colors);
  drawPhases(pen, lanes, top, xOf, NAMES_PX + plot, colors);
  top += PHASE_PX + GAP_PX;
  MARK_LANES.forEach(({ label }, k) => {
    name(pen, label, top + MARK_PX / 2, colors);
    pen.fillStyle = colors.grid;
    pen.fillRect(NAMES_PX, top + MARK_PX, plot, GAP_PX);
    drawMarks(pen, lanes.marks[k] ?? [], top + MARK_PX / 2, xOf, colors);
    top += MARK_PX + GAP_PX;
  });
  name(pen, "innov/δ", top + RIBBON_PX / 2, colors);
  drawRibbon(pen, lanes.ribbon, top, colors);
  top += RIBBON_PX + GAP_PX;
  drawClock(pen, lanes, top, plot, xOf, colors);
}

function name(pen: CanvasRenderingContext2D, text: string, y: number, colors: ChartColors): void {
  pen.font = FONT;
  pen.textAlign = "right";
  pen.fillStyle = colors.muted;
  pen.fillText(text, NAMES_PX - 8, y + 0.5);
}

function drawPhases(pen: CanvasRenderingContext2D, { phases, span }: Lanes, top: number, xOf: (time: number) => number, right: number, colors: ChartColors): void {
  pen.textAlign = "left";
  phases.forEach((phase, k) => {
    const [from, to] = [Math.max(NAMES_PX, xOf(Math.max(span[0], phase.span[0]))), Math.min(right, xOf(phase.span[1]))];
    if (to <= from) return;
    pen.fillStyle = k % 2 === 0 ? colors.edge : colors.grid;
    pen.fillRect(from, top, Math.max(1, to - from - 1), PHASE_PX);
    const room = to - from - 8;
    const text = fitted(pen, phase.text, room);
    pen.fillStyle = colors.ink;
    if (text !== "") pen.fillText(text, from + 4, top + PHASE_PX / 2 + 0.5);
  });
}

/** The text, shortened to `room` px; empty if less than a few letters would remain. */
function fitted(pen: CanvasRenderingContext2D, text: string, room: number): string {
  if (room < 24) return "";
  if (pen.measureText(text).width <= room) return text;
  let length = text.length;
  while (length > 3 && pen.measureText(`${text.slice(0, length).trimEnd()}…`).width > room) length -= 1;
  return length > 3 ? `${text.slice(0, length).trimEnd()}…` : "";
}

function drawMarks(pen: CanvasRenderingContext2D, marks: Lanes["marks"][number], y: number, xOf: (time: number) => number, colors: ChartColors): void {
  pen.font = GLYPH_FONT;
  pen.textAlign = "center";
  for (const { x, head, marks: joined } of clusters(marks, xOf, GLYPHS_APART_PX)) {
    if (x < NAMES_PX - 1) continue;
    pen.fillStyle = markColor(head, colors);
    pen.fillText(markKind(head.kind).icon, x, y + 0.5);
    if (joined.length > 1) pen.fillRect(x - 4, y + 5.5, 8, 1);
  }
}

function drawRibbon(pen: CanvasRenderingContext2D, ribbon: number[], top: number, colors: ChartColors): void {
  ribbon.forEach((ratio, x) => {
    if (Number.isNaN(ratio)) return;
    const height = Math.max(1, Math.min(1, ratio / RIBBON_FULL) * RIBBON_PX);
    pen.fillStyle = ratio >= 1 ? colors.bad : ratio >= NEAR ? colors.warn : colors.third;
    pen.fillRect(NAMES_PX + x, top + RIBBON_PX - height, 1, height);
  });
  pen.fillStyle = colors.setpoint;
  const at = Math.round(top + RIBBON_PX * (1 - 1 / RIBBON_FULL));
  for (let x = 0; x < ribbon.length; x += 6) pen.fillRect(NAMES_PX + x, at, 3, 1);
}

function drawClock(pen: CanvasRenderingContext2D, { span }: Lanes, top: number, plot: number, xOf: (time: number) => number, colors: ChartColors): void {
  pen.font = FONT;
  pen.textAlign = "center";
  const right = NAMES_PX + plot + RIGHT_PX;
  for (const split of clockSplits(span, plot, CLOCK_APART_PX)) {
    const [x, text] = [xOf(split), clockText(split)];
    pen.fillStyle = colors.grid;
    pen.fillRect(Math.round(x), 0, 1, top);
    pen.fillStyle = colors.muted;
    pen.fillText(text, Math.min(x, right - pen.measureText(text).width / 2), top + CLOCK_PX / 2 + 0.5);
  }
}
