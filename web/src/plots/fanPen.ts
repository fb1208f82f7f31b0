// Draws a fan: its band, its line, and a vertical line at the lead.
import type { ChartColors } from "./colors";
import type { Fan, FanPoint } from "./fan";

const BAND_ALPHA = 0.24;
const LABEL_PX = 10;
/** The lead has its name only where it is at least this far from now, px. */
const NAMED_FROM_PX = 12;
const DASH_PX = [3, 3];
const GAP_PX = 4;
const FONT = "system-ui, DejaVu Sans, sans-serif";

/** An area with a time axis and a value axis. */
export interface Field {
  pen: CanvasRenderingContext2D;
  left: number;
  top: number;
  width: number;
  height: number;
  xOf(time: number): number;
  yOf(value: number): number;
  /** Pixels of the canvas per pixel of the page. */
  ratio: number;
}

export function drawFan(field: Field, fan: Fan, colors: ChartColors, lineWidth: number): void {
  const { pen, left, top, width, height, xOf, yOf, ratio } = field;
  pen.save();
  pen.beginPath();
  pen.rect(left, top, width, height);
  pen.clip();
  pen.fillStyle = colors.fourth;
  pen.globalAlpha = BAND_ALPHA;
  fillBand(field, fan.points);
  pen.globalAlpha = 1;
  pen.strokeStyle = colors.fourth;
  if (fan.leadS > 0) drawLead(field, fan, colors);
  pen.lineWidth = lineWidth * ratio;
  pen.setLineDash([]);
  pen.beginPath();
  for (const { time, value } of fan.points) pen.lineTo(xOf(time), yOf(value));
  pen.stroke();
  pen.restore();
}

function fillBand({ pen, xOf, yOf }: Field, points: FanPoint[]): void {
  const banded = points.flatMap(({ time, value, half }) => (half === null ? [] : [{ time, value, half }]));
  if (banded.length < 2) return;
  pen.beginPath();
  for (const { time, value, half } of banded) pen.lineTo(xOf(time), yOf(value + half));
  for (const { time, value, half } of banded.toReversed()) pen.lineTo(xOf(time), yOf(value - half));
  pen.closePath();
  pen.fill();
}

function drawLead({ pen, left, top, width, height, xOf, ratio }: Field, { time, leadS }: Fan, colors: ChartColors): void {
  const x = Math.round(xOf(time + leadS)) + 0.5;
  pen.lineWidth = ratio;
  pen.setLineDash(DASH_PX.map((length) => length * ratio));
  pen.beginPath();
  pen.moveTo(x, top);
  pen.lineTo(x, top + height);
  pen.stroke();
  if (x - xOf(time) < NAMED_FROM_PX * ratio) return;
  const text = leadText(leadS);
  pen.font = `${LABEL_PX * ratio}px ${FONT}`;
  pen.textBaseline = "top";
  pen.fillStyle = colors.muted;
  const room = left + width - x - GAP_PX * ratio;
  const fits = pen.measureText(text).width <= room;
  pen.textAlign = fits ? "left" : "right";
  pen.fillText(text, fits ? x + GAP_PX * ratio : xOf(time) - GAP_PX * ratio, top + ratio);
}

/** The lead in words. */
export function leadText(leadS: number): string {
  return leadS > 0 ? `lead ${Math.round(leadS * 1000)} ms` : "no lead";
}
