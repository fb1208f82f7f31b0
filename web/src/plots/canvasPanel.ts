// The frame of a panel that draws on a canvas of its own: heading with values, canvas, size. The close-up and the spectrum have it.
import { element } from "../panels/dom";
import { penOf } from "./software";
import type { ChartSpec } from "./spec";

/** An entry of the heading: a line or words, then a value. */
export interface Entry {
  label: string;
  title?: string;
  /** Colour of the line before the label; none if the entry has no line. */
  color?: string;
  output?: HTMLOutputElement;
}

export class CanvasPanel {
  readonly root: HTMLElement;
  readonly canvas = element("canvas", { ariaHidden: "true" });
  readonly unit = element("span", { className: "muted" });
  /** Width and height of the canvas, px. */
  size: [number, number] = [0, 0];
  private readonly sizes = new ResizeObserver(([entry]) => {
    const { width, height } = entry?.contentRect ?? { width: 0, height: 0 };
    this.size = [width, height];
    this.resized();
  });

  /** `kind` is a class of the panel; `resized` is called when the canvas has another size and must be drawn anew. */
  constructor(
    spec: ChartSpec,
    kind: string,
    entries: Entry[],
    private readonly resized: () => void,
  ) {
    const plot = element("div", { className: "plot" }, [this.canvas]);
    const key = element("ul", {}, entries.map(item));
    const head = element("header", { className: "chart-head" }, [element("h3", { title: spec.title }, [spec.title, this.unit]), key]);
    this.root = element("article", { className: `chart ${kind}`, ariaLabel: spec.title, tabIndex: 0, role: "figure" }, [head, plot]);
    this.root.dataset["key"] = spec.key;
    this.sizes.observe(plot);
  }

  /** A pen on the empty canvas, which draws in px of the page; null if the browser gives none. */
  pen(): CanvasRenderingContext2D | null {
    return emptied(this.canvas, this.size);
  }

  destroy(): void {
    this.sizes.disconnect();
    this.root.remove();
  }
}

/** A pen on `canvas`, which has `width` x `height` px of the page and is empty; null if the browser gives none. */
export function emptied(canvas: HTMLCanvasElement, [width, height]: [number, number]): CanvasRenderingContext2D | null {
  const ratio = devicePixelRatio;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
  const pen = penOf(canvas);
  pen?.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen?.clearRect(0, 0, width, height);
  return pen;
}

function item({ label, title, color, output }: Entry): HTMLElement {
  const line = color === undefined ? [] : [element("i", { className: "line" })];
  for (const mark of line) mark.style.color = color ?? "";
  return element("li", { title: title ?? "" }, [...line, label, ...(output === undefined ? [] : [output])]);
}
