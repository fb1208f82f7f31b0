// The panel with the eigenvalues of the adapter's covariance at the cursor, else at the playhead, as bars, largest first, on a logarithmic
// axis.
import type { Store } from "../data/store";
import { element, setText } from "../panels/dom";
import { CanvasPanel } from "./canvasPanel";
import type { ChartColors } from "./colors";
import type { Frame } from "./frame";
import { AXIS_WIDTH_PX, RIGHT_PX } from "./options";
import type { Panel, Picture, SeriesReading } from "./panel";
import { type Bounds, decadeRange, formatValue } from "./range";
import type { ChartSpec } from "./spec";

const FOOT_PX = 4;
const FONT = "11px system-ui, DejaVu Sans, sans-serif";

export class SpectrumBars implements Panel {
  readonly over = null;
  visible = true;
  round = -1;
  private readonly panel: CanvasPanel;
  private readonly largest = element("output", { ariaLive: "off" });
  private readonly smallest = element("output", { ariaLive: "off" });
  private range: Bounds | null = null;
  private tick = NaN;

  constructor(
    readonly spec: ChartSpec,
    private readonly store: Store,
    private readonly colors: ChartColors,
  ) {
    const entries = [{ label: "largest", output: this.largest }, { label: "smallest", output: this.smallest }];
    this.panel = new CanvasPanel(spec, "bars", entries, () => (this.round = -1));
  }

  get root(): HTMLElement {
    return this.panel.root;
  }

  refresh(_: Frame): void {
    this.redraw();
  }

  point(time: number | null): void {
    const tick = time === null ? this.store.shownTick : this.store.tickAt(time);
    if (Object.is(tick, this.tick)) return;
    this.tick = tick;
    this.redraw();
  }

  private redraw(): void {
    const values = [...this.values()].filter((value) => value > 0);
    if (values.length > 0) this.range = decadeRange(this.range, [Math.min(...values), Math.max(...values)]);
    this.draw(values);
  }

  write(): void {
    const values = this.values();
    setText(this.largest, formatValue(values[0]));
    setText(this.smallest, formatValue(values[values.length - 1]));
    this.root.ariaLabel = this.sentence();
  }

  select(): void {}

  readings(): SeriesReading[] {
    return [...this.values()].map((value, k) => ({ channel: `eigenvalue ${k + 1}`, label: String(k + 1), value, plotted: [value, value], breaks: 0 }));
  }

  sentence(): string {
    const values = this.values();
    return `${this.spec.title}: ${values.length} eigenvalues from ${formatValue(values[0])} to ${formatValue(values[values.length - 1])}`;
  }

  picture(): Picture {
    const entry = (label: string, text: string): Picture["entries"][number] => ({ label, text, color: this.colors.fourth, dash: [] });
    return { title: this.spec.title, entries: [entry("largest", this.largest.textContent ?? ""), entry("smallest", this.smallest.textContent ?? "")], canvas: this.panel.canvas };
  }

  destroy(): void {
    this.panel.destroy();
  }

  private values(): Float32Array {
    return this.store.pictures.spectrumAt(this.tick);
  }

  private draw(values: number[]): void {
    const pen = this.panel.pen();
    if (pen === null) return;
    const [width, height] = this.panel.size;
    const [low, high] = this.range ?? [1, 10];
    const yOf = (value: number): number => FOOT_PX + (1 - Math.log(value / low) / Math.log(high / low)) * (height - 2 * FOOT_PX);
    pen.font = FONT;
    pen.fillStyle = this.colors.muted;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of [low, high]) pen.fillText(formatDecade(value), AXIS_WIDTH_PX - 5, Math.min(height - 6, Math.max(6, yOf(value))));
    const room = (width - AXIS_WIDTH_PX - RIGHT_PX) / Math.max(1, values.length);
    pen.fillStyle = this.colors.fourth;
    values.forEach((value, k) => {
      const y = yOf(value);
      pen.fillRect(AXIS_WIDTH_PX + k * room + Math.min(1, room / 4), y, Math.max(1, room - Math.min(2, room / 2)), height - FOOT_PX - y);
    });
  }
}

function formatDecade(value: number): string {
  return (value >= 1e5 || value < 1e-3 ? value.toExponential(0) : String(value)).replace("e+", "e").replace("-", "−");
}
