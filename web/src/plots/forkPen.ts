// The lines of the forks on a chart: dashed, in the colour of the fork, from the moment of the fork on.
import type { Point } from "../data/forkRows";
import type { Store } from "../data/store";
import type { ChartColors } from "./colors";
import type { Field } from "./fanPen";
import type { Frame } from "./frame";

const DASH_PX = [6, 3];

export interface ForkLine {
  slot: number;
  points: Point[];
}

/** The lines of one column within a frame; a logarithmic chart leaves out what it cannot show. */
export function forkLines(store: Store, column: number, scale: number, { ticks, bucket }: Frame, logarithmic: boolean): ForkLine[] {
  return store.forks.list.map(({ id, slot }) => {
    const points = store.forks.line(id, column, ticks, Math.max(1, Math.floor(bucket / 2)), store.timeOf);
    const scaled = points.map(([time, value]): Point => [time, value * scale]);
    return { slot, points: logarithmic ? scaled.filter(([, value]) => value > 0) : scaled };
  });
}

export function drawForks({ pen, left, top, width, height, ratio, xOf, yOf }: Field, lines: ForkLine[], colors: ChartColors, lineWidth: number): void {
  if (lines.length === 0) return;
  pen.save();
  pen.beginPath();
  pen.rect(left, top, width, height);
  pen.clip();
  pen.lineWidth = lineWidth * 1.3 * ratio;
  pen.setLineDash(DASH_PX.map((part) => part * ratio));
  for (const { slot, points } of lines) {
    pen.strokeStyle = colors.forks[slot % colors.forks.length] ?? colors.ink;
    pen.beginPath();
    points.forEach(([time, value], k) => (k === 0 ? pen.moveTo(xOf(time), yOf(value)) : pen.lineTo(xOf(time), yOf(value))));
    pen.stroke();
  }
  pen.restore();
}
