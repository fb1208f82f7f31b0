// The column of charts on one clock, drawn within a budget: each at most ten times a second, few of them per frame.
import { bucketTicks } from "../data/decimate";
import type { Store } from "../data/store";
import { byId, element, option, radioGroup } from "../panels/dom";
import type { Palette } from "../panels/theme";
import { Chart } from "./chart";
import { chartSpecs, symbolOf } from "./spec";

const REDRAW_MS = 100;
const WINDOWS_S = [5, 10, 20, 60];
const FIRST_WINDOW_S = 20;

export class ChartColumn {
  private charts: Chart[] = [];
  private row = "z";
  private windowS = FIRST_WINDOW_S;
  private readonly root = byId("charts");
  private readonly watcher = new IntersectionObserver((entries) => this.seen(entries));

  constructor(
    private readonly store: Store,
    private palette: Palette,
    private readonly software: boolean,
  ) {
    const select = byId<HTMLSelectElement>("window");
    select.append(...WINDOWS_S.map((seconds) => option(String(seconds), `${seconds} s`, seconds === FIRST_WINDOW_S)));
    select.addEventListener("change", () => {
      this.windowS = Number(select.value);
      this.redraw();
    });
  }

  /** Rows and channels may have changed. */
  rebuild(): void {
    const rows = this.store.rows();
    if (!rows.includes(this.row)) this.row = rows[0] ?? "";
    radioGroup(byId("rows"), rows.map((row) => ({ value: row, label: symbolOf(row) })), this.row, (row) => {
      this.row = row;
      this.build();
    });
    this.build();
  }

  recolor(palette: Palette): void {
    this.palette = palette;
    this.build();
  }

  /** Everything is to be drawn again, new data or not. */
  redraw(): void {
    this.charts.forEach((chart) => chart.expire());
  }

  /** Draws what is due. */
  frame(now: number): void {
    if (this.store.hello === null) return;
    const tick = this.store.lastTick;
    const due = this.charts.filter((chart) => chart.visible && chart.drawnTick !== tick && now - chart.drawnAt >= REDRAW_MS);
    due.sort((a, b) => a.drawnAt - b.drawnAt);
    const [from, to] = this.span();
    const width = Math.max(100, this.root.clientWidth - 60);
    const bucket = bucketTicks(this.windowS / this.store.hello.tick_s, width / 2);
    for (const chart of due.slice(0, this.software ? 1 : 2)) {
      chart.refresh(from, to, bucket);
      chart.drawnAt = now;
      chart.drawnTick = tick;
    }
  }

  private span(): [number, number] {
    const now = this.store.timeOf(this.store.lastTick);
    const from = Math.max(0, now - this.windowS);
    return [from, from + this.windowS];
  }

  private build(): void {
    this.charts.forEach((chart) => chart.destroy());
    this.watcher.disconnect();
    if (this.store.hello === null) return;
    const specs = chartSpecs(this.row);
    const lineWidth = this.software ? 1 : 1.5;
    this.charts = specs.map((spec, index) => new Chart(spec, this.store, { palette: this.palette, lineWidth, clock: index === specs.length - 1 }));
    this.root.replaceChildren(...this.charts.map((chart) => chart.root));
    if (this.charts.length === 0) this.root.append(element("p", { textContent: "No channels." }));
    this.charts.forEach((chart) => this.watcher.observe(chart.root));
    this.redraw();
  }

  private seen(entries: IntersectionObserverEntry[]): void {
    for (const entry of entries) {
      const chart = this.charts.find((candidate) => candidate.root === entry.target);
      if (chart === undefined) continue;
      chart.visible = entry.isIntersecting;
      chart.expire();
    }
  }
}
