// The timeline under the charts: the glyphs of marks, the labels of the shared time axis, and the time at the cursor.
import { byId, element, setText } from "../panels/dom";
import { emptied } from "./canvasPanel";
import { type Cluster, clusters, markKind } from "./clusters";
import { clockSplits, clockText } from "./clock";
import type { ChartColors } from "./colors";
import type { Frame } from "./frame";
import { markColor } from "./marks";
import { AXIS_WIDTH_PX, CLOCK_APART_PX, RIGHT_PX } from "./options";

const GLYPH_ROW_PX = 17;
const GLYPHS_APART_PX = 14;
/** A pointer that is this close to a glyph or to its line points at it, px. */
const REACH_PX = 6;
const FONT = "system-ui, DejaVu Sans, sans-serif";

export class Timeline {
  readonly root = byId("timeline");
  private readonly canvas = element("canvas", { ariaHidden: "true" });
  private readonly at = element("output", { className: "clock-cursor", ariaLive: "off", hidden: true });
  private frame: Frame | null = null;
  private groups: Cluster[] = [];
  private width = 0;

  constructor(private colors: ChartColors) {
    this.root.replaceChildren(this.canvas, this.at);
  }

  recolor(colors: ChartColors): void {
    this.colors = colors;
  }

  /** `width` of the column of charts, px. */
  refresh(frame: Frame, width: number): void {
    this.frame = frame;
    this.width = Math.max(1, width - AXIS_WIDTH_PX - RIGHT_PX);
    this.groups = clusters(frame.marks, (time) => this.xOf(time), GLYPHS_APART_PX);
    this.draw(width);
  }

  point(time: number | null): void {
    if (this.frame === null) return;
    const [from, to] = this.frame.span;
    this.at.hidden = time === null || time < from || time > to;
    if (time === null || this.at.hidden) return;
    setText(this.at, `${time.toFixed(2)} s`);
    const x = Math.min(this.width + AXIS_WIDTH_PX - 20, Math.max(30, this.xOf(time)));
    this.at.style.transform = `translateX(calc(${x.toFixed(1)}px - 50%))`;
  }

  /** The marks at which a pointer at `x` px of the column points; null if there are none. */
  marksAt(x: number): Cluster | null {
    let best: Cluster | null = null;
    for (const group of this.groups) {
      if (Math.abs(group.x - x) <= REACH_PX && (best === null || Math.abs(group.x - x) < Math.abs(best.x - x))) best = group;
    }
    return best;
  }

  /** Position of `x` px of the column as a part of the width of the plots. */
  partAt(x: number): number {
    return (x - AXIS_WIDTH_PX) / this.width;
  }

  picture(): HTMLCanvasElement {
    return this.canvas;
  }

  private xOf(time: number): number {
    const [from, to] = this.frame?.span ?? [0, 1];
    return AXIS_WIDTH_PX + ((time - from) / (to - from)) * this.width;
  }

  private draw(width: number): void {
    const height = this.root.clientHeight;
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${height}px` });
    const pen = emptied(this.canvas, [width, height]);
    if (pen === null || this.frame === null) return;
    this.labels(pen, this.frame, height);
    this.glyphs(pen);
  }

  private labels(pen: CanvasRenderingContext2D, frame: Frame, height: number): void {
    pen.font = `11px ${FONT}`;
    pen.fillStyle = this.colors.muted;
    pen.textAlign = "center";
    pen.textBaseline = "bottom";
    const right = AXIS_WIDTH_PX + this.width + RIGHT_PX;
    for (const split of clockSplits(frame.span, this.width, CLOCK_APART_PX)) {
      const text = clockText(split);
      const half = pen.measureText(text).width / 2;
      pen.fillText(text, Math.min(this.xOf(split), right - half), height - 1);
    }
  }

  private glyphs(pen: CanvasRenderingContext2D): void {
    pen.font = `13px ${FONT}`;
    pen.textBaseline = "middle";
    for (const { x, head, marks } of this.groups) {
      if (x < AXIS_WIDTH_PX - 1) continue;
      pen.fillStyle = markColor(head, this.colors);
      pen.textAlign = "center";
      pen.fillText(markKind(head.kind).icon, x, GLYPH_ROW_PX / 2);
      if (marks.length < 2) continue;
      pen.fillRect(x - 4, GLYPH_ROW_PX - 2, 8, 1.5);
    }
  }
}
