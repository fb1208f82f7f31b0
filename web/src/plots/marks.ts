// What is drawn over the lines: resets, and where a value is unknown.
import uPlot from "uplot";
import type { Sample } from "../data/decimate";

const RAIL_PX = 3;

/** A dashed line at every reset in view, with its icon where asked. */
export function drawResets(plot: uPlot, times: number[], color: string, icon: boolean): void {
  const { ctx, bbox } = plot;
  const ratio = uPlot.pxRatio;
  ctx.save();
  ctx.strokeStyle = color;
  ctx.fillStyle = color;
  ctx.lineWidth = ratio;
  ctx.font = `${13 * ratio}px system-ui, sans-serif`;
  ctx.textAlign = "center";
  ctx.textBaseline = "top";
  for (const time of times) {
    const x = Math.round(plot.valToPos(time, "x", true));
    if (x < bbox.left || x > bbox.left + bbox.width) continue;
    ctx.setLineDash([4 * ratio, 3 * ratio]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top + (icon ? 15 * ratio : 0));
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    if (icon) ctx.fillText("↺", x, bbox.top);
  }
  ctx.restore();
}

/** A rail in the series' colour at the foot of the chart wherever its value is unknown. */
export function drawUnknown(plot: uPlot, x: number[], series: Sample[][], colors: string[]): void {
  const { ctx, bbox } = plot;
  const ratio = uPlot.pxRatio;
  ctx.save();
  series.forEach((values, k) => {
    ctx.fillStyle = colors[k] ?? "gray";
    const y = bbox.top + bbox.height - (k + 1) * RAIL_PX * ratio;
    for (const [from, to] of unknownSpans(x, values)) {
      const left = Math.max(bbox.left, plot.valToPos(from, "x", true));
      const right = Math.min(bbox.left + bbox.width, plot.valToPos(to, "x", true));
      if (right >= left) ctx.fillRect(left, y, Math.max(ratio, right - left), (RAIL_PX - 1) * ratio);
    }
  });
  ctx.restore();
}

/** Stretches of x over which `values` are null, each from its first null to its last. */
export function unknownSpans(x: number[], values: Sample[]): [number, number][] {
  const spans: [number, number][] = [];
  let from = -1;
  for (let i = 0; i <= values.length; i += 1) {
    if (i < values.length && values[i] === null) {
      if (from < 0) from = i;
    } else if (from >= 0 && values[i] !== undefined) {
      spans.push([x[from] ?? 0, x[i - 1] ?? 0]);
      from = -1;
    } else if (from >= 0 && i === values.length) {
      spans.push([x[from] ?? 0, x[i - 1] ?? 0]);
    }
  }
  return spans;
}
