// Composes a picture of the charts, and hands files to the browser.
import { element } from "../panels/dom";
import { clockText } from "./clock";
import type { ChartColors } from "./colors";
import type { Picture } from "./panel";
import type { Span } from "./view";

const HEAD_PX = 20;
const TITLE_PX = 26;
const SIDE_PX = 10;
/** Room for the stroke beside a line's name and for the gap to the next name, px. */
const ENTRY_PX = 28;
const FONT = "system-ui, DejaVu Sans, sans-serif";

/** Draws all pictures below one another on the background of the theme, with a title and the timeline. */
export function compose(title: string, pictures: Picture[], timeline: HTMLCanvasElement, colors: ChartColors): HTMLCanvasElement {
  const ratio = devicePixelRatio;
  const width = Math.max(timeline.width, ...pictures.map(({ canvas }) => canvas.width));
  const sheet = element("canvas", { width, height: 1 });
  const pen = sheet.getContext("2d");
  if (pen === null) throw new Error("this browser gives no canvas for the picture");
  const lines = pictures.map((picture) => (headWidth(pen, picture, ratio) > width ? 2 : 1));
  const heads = lines.map((count) => count * HEAD_PX * ratio);
  sheet.height = pictures.reduce((sum, { canvas }, k) => sum + canvas.height + (heads[k] ?? 0), TITLE_PX * ratio + timeline.height);
  pen.fillStyle = colors.panel;
  pen.fillRect(0, 0, width, sheet.height);
  pen.textBaseline = "middle";
  write(pen, title, SIDE_PX * ratio, (TITLE_PX * ratio) / 2, titleFont(ratio), colors.ink, "left");
  let top = TITLE_PX * ratio;
  pictures.forEach((picture, k) => {
    const middle = top + (HEAD_PX * ratio) / 2;
    write(pen, picture.title, SIDE_PX * ratio, middle, titleFont(ratio), colors.ink, "left");
    top += heads[k] ?? 0;
    entries(pen, picture, top - (HEAD_PX * ratio) / 2, width, ratio, colors);
    pen.drawImage(picture.canvas, 0, top);
    top += picture.canvas.height;
  });
  pen.drawImage(timeline, 0, top);
  return sheet;
}

const titleFont = (ratio: number): string => `600 ${12 * ratio}px ${FONT}`;
const entryFont = (ratio: number): string => `${11 * ratio}px ${FONT}`;

/** Width that the title and the line names of a chart need in one line, px. */
function headWidth(pen: CanvasRenderingContext2D, picture: Picture, ratio: number): number {
  pen.font = titleFont(ratio);
  const title = pen.measureText(picture.title).width;
  pen.font = entryFont(ratio);
  return picture.entries.reduce((sum, { label, text }) => sum + pen.measureText(`${label} ${text}`).width + ENTRY_PX * ratio, title + 2 * SIDE_PX * ratio);
}

/** Draws the name and the value of each line of a chart, beginning at the right. */
function entries(pen: CanvasRenderingContext2D, picture: Picture, y: number, width: number, ratio: number, colors: ChartColors): void {
  let right = width - SIDE_PX * ratio;
  for (const { label, text, color, dash } of [...picture.entries].reverse()) {
    right -= write(pen, `${label} ${text}`, right, y, entryFont(ratio), colors.ink, "right") + 4 * ratio;
    pen.strokeStyle = color;
    pen.lineWidth = 2 * ratio;
    pen.setLineDash(dash.map((length) => (length * ratio) / 2));
    pen.beginPath();
    pen.moveTo(right - 14 * ratio, y);
    pen.lineTo(right, y);
    pen.stroke();
    pen.setLineDash([]);
    right -= (ENTRY_PX - 4) * ratio;
  }
}

function write(pen: CanvasRenderingContext2D, text: string, x: number, y: number, font: string, color: string, align: CanvasTextAlign): number {
  Object.assign(pen, { font, fillStyle: color, textAlign: align });
  pen.fillText(text, x, y);
  return pen.measureText(text).width;
}

/** Scenario and stretch as the stem of a file name, for example `hover_12.5s-32.5s`. */
export function fileStem(scenario: string, [from, to]: Span): string {
  return `${scenario}_${clockText(from)}-${clockText(to)}`.replaceAll(" ", "").replaceAll("−", "-");
}

/** Hands a file to the browser. */
export function download(name: string, blob: Blob): void {
  const link = element("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
