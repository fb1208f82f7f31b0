// Draws the axes and lines of the close-up.
import type { ChartColors } from "./colors";
import type { Field } from "./fanPen";
import { type Bounds, niceStep } from "./range";

const FONT = "11px system-ui, DejaVu Sans, sans-serif";
/** Smallest distance between the labels of the value axis, px. */
const LABELS_APART_PX = 18;
/** Distance of the lines of the time axis, ms. */
const GRID_MS = 250;
const LABEL_GAP_PX = 5;

/** Draws a grid with values at the left and times from `now` below. */
export function drawAxes({ pen, left, top, width, height, xOf, yOf }: Field, colors: ChartColors, [low, high]: Bounds, now: number, aheadS: number, pastS: number): void {
  pen.save();
  pen.font = FONT;
  pen.lineWidth = 1;
  pen.fillStyle = colors.muted;
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  const step = niceStep(((high - low) * LABELS_APART_PX) / height);
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) {
    const y = Math.round(yOf(k * step)) + 0.5;
    stroke(pen, colors.grid, [left, y], [left + width, y]);
    pen.fillText(String(Number((k * step).toPrecision(6))).replace("-", "−"), left - LABEL_GAP_PX, y);
  }
  pen.textBaseline = "top";
  for (let ms = Math.round(aheadS * 1000); ms >= -pastS * 1000; ms -= GRID_MS) {
    const x = Math.round(xOf(now + ms / 1000)) + 0.5;
    stroke(pen, ms === 0 ? colors.fourth : colors.grid, [x, top], [x, top + height]);
    pen.textAlign = ms / 1000 === aheadS ? "right" : ms / 1000 === -pastS ? "left" : "center";
    pen.fillText(ms === 0 ? "now" : `${ms > 0 ? "+" : "−"}${Math.abs(ms)} ms`, x, top + height + 2);
  }
  pen.restore();
}

function stroke(pen: CanvasRenderingContext2D, color: string, from: [number, number], to: [number, number]): void {
  pen.strokeStyle = color;
  pen.beginPath();
  pen.moveTo(...from);
  pen.lineTo(...to);
  pen.stroke();
}

/** Draws values that begin at `start` and are `tickS` apart; unknown values break the line. */
export function drawLine({ pen, left, top, width, height, xOf, yOf }: Field, values: number[], start: number, tickS: number, style: { color: string; dash: number[]; width: number }): void {
  pen.save();
  pen.beginPath();
  pen.rect(left, top, width, height);
  pen.clip();
  pen.strokeStyle = style.color;
  pen.lineWidth = style.width;
  pen.setLineDash(style.dash);
  pen.beginPath();
  let open = false;
  values.forEach((value, k) => {
    const known = !Number.isNaN(value);
    if (known) pen[open ? "lineTo" : "moveTo"](xOf(start + k * tickS), yOf(value));
    open = known;
  });
  pen.stroke();
  pen.restore();
}
