// The column of charts with one shared time axis. It draws in rounds within a budget: at most ten rounds a second and a few charts
// per frame. All charts of a round show the same frame of data.
import type { Store } from "../data/store";
import { Beat } from "../panels/beat";
import { byId, option, radioGroup, setText } from "../panels/dom";
import { notify } from "../panels/notices";
import type { EventInfo } from "../protocol";
import { addOwn, load, type OwnChart, save, standard, WINDOWS_S } from "./arrangement";
import { registerChartActions, registerChartKeys } from "./chartKeys";
import { readColors } from "./colors";
import { saveCsv, savePng } from "./files";
import { type Frame, rangeOf, takeFrame } from "./frame";
import { ChartMenu } from "./menu";
import { AXIS_WIDTH_PX, RIGHT_PX } from "./options";
import type { Panel, SeriesReading } from "./panel";
import { Panels } from "./panels";
import { ChannelPicker } from "./picker";
import { listenPan, listenPointer } from "./pointer";
import { RangeTable } from "./rangeTable";
import { type ChartSpec, symbolOf } from "./spec";
import { Timeline } from "./timeline";
import { MarkTip } from "./tip";
import { View } from "./view";

const ROUND_MS = 100;
/** Time over which a round is spread, ms: one chart per frame while the page draws fast, several per frame while it is slow. */
const SPREAD_MS = { software: 250, hardware: 100 };
/** The text for screen readers is written when the cursor has rested for this long, ms. */
const SPEAK_AFTER_MS = 500;

/** Largest part of the window that forks may take beyond now. */
const FORKS_PART = 0.4;

export class ChartColumn {
  /** Called with the tick under the cursor when it changes; null without a cursor. */
  onCursor: (tick: number | null) => void = () => undefined;
  readonly view: View;
  readonly arrangement = load();
  readonly table: RangeTable;
  private readonly root = byId("charts");
  private readonly panels: Panels;
  private readonly timeline: Timeline;
  private readonly tip = new MarkTip();
  private readonly menu: ChartMenu;
  private readonly picker: ChannelPicker;
  private readonly windows = byId<HTMLSelectElement>("window");
  private colors = readColors();
  private current: Frame | null = null;
  private round = 0;
  private roundAt = -Infinity;
  private frameAt = -Infinity;
  private drawnVersion = -1;
  private drawnEvents: EventInfo[] | null = null;
  private drawnForks = 0;
  private expired = true;
  private cursor: number | null = null;
  private speech = 0;
  private readonly texts = new Beat();
  private spectrum = false;
  /** File that is mirrored; null for a simulated flight. */
  private recording: string | null = null;

  constructor(
    private readonly store: Store,
    private readonly software: boolean,
  ) {
    const now = (): number => Math.max(0, store.timeOf(store.lastTick));
    const oldest = (): number => (store.history.length === 0 ? 0 : store.timeOf(store.history.first));
    this.view = new View({ now, oldest });
    this.view.windowS = this.arrangement.windowS;
    this.table = new RangeTable(store, this.view);
    this.timeline = new Timeline(this.colors);
    this.panels = new Panels(this.root, store, software ? 1 : 1.5, { made: (panel) => this.listen(panel), toggleZscore: () => this.toggleZscore(), choose: (row) => this.chooseRow(row) });
    this.menu = new ChartMenu({
      changed: () => this.changed(),
      edit: (own) => this.edit(own),
      add: () => this.add(),
      reset: () => this.toDefault(),
      saveCsv: () => saveCsv(this.store, this.view.span(), this.panels.list),
      savePng: () => this.picture(),
      clearMarkers: () => {
        this.view.markers = [];
        this.view.version += 1;
      },
    });
    this.picker = new ChannelPicker({
      changed: () => this.changed(),
      remove: (own) => {
        this.arrangement.own = this.arrangement.own.filter((other) => other !== own);
        this.changed();
      },
    });
    this.windows.append(...WINDOWS_S.map((seconds) => option(String(seconds), seconds < 100 ? `${seconds} s` : `${seconds / 60} min`, seconds === this.view.windowS)));
    this.windows.addEventListener("change", () => this.chooseWindow(Number(this.windows.value)));
    const hover = (event: PointerEvent | null): void => this.hover(event);
    listenPan(this.timeline.root, this.view, () => this.plotWidth(), { hover, click: (event) => this.clickMark(event) });
    registerChartKeys({ view: this.view, cursor: () => this.view.cursor() ?? now() });
    const files = { saveCsv: () => saveCsv(this.store, this.view.span(), this.panels.list), savePng: () => this.picture() };
    const chosen = { toggleZscore: () => this.toggleZscore(), add: () => this.add(), toDefault: () => this.toDefault() };
    registerChartActions({ ...files, ...chosen, forgetRange: () => this.view.clearRange() });
  }

  /** Takes a new description of the flight, whose coordinates and channels may differ. */
  rebuild(): void {
    const rows = this.store.rows();
    if (!rows.includes(this.arrangement.row)) this.arrangement.row = rows.includes("z") ? "z" : (rows[0] ?? "");
    radioGroup(byId("rows"), rows.map((row) => ({ value: row, label: symbolOf(row) })), this.arrangement.row, (row) => {
      this.arrangement.row = row;
      this.changed();
    });
    this.view.leadS = this.lead();
    const recording = this.store.hello?.mirror?.file ?? null;
    this.view.clear(recording !== null && recording === this.recording);
    this.recording = recording;
    this.sync(true);
  }

  /** Shows charts of this flight alone before the others. */
  showFirst(specs: ChartSpec[]): void {
    this.panels.extra = specs;
    this.sync(true);
  }

  recolor(): void {
    this.colors = readColors();
    this.timeline.recolor(this.colors);
    if (this.store.hello !== null) this.sync(true);
  }

  /** Clears all lines, for another flight or for another moment of a recording. */
  clear(): void {
    this.view.clear(this.recording !== null);
    this.expired = true;
  }

  /** Draws the charts that are due in this frame. */
  frame(now: number): void {
    if (this.store.hello === null) return;
    if (this.panels.hasSpectrum() !== this.spectrum) this.sync(false);
    const due = this.panels.list.filter(({ visible, round }) => visible && round !== this.round).sort((a, b) => a.round - b.round);
    const touched = this.view.version !== this.drawnVersion || this.expired;
    if (touched || (due.length === 0 && now - this.roundAt >= ROUND_MS && this.outdated())) {
      this.begin(now);
      due.splice(0, due.length, ...this.panels.list.filter(({ visible }) => visible).sort((a, b) => a.round - b.round));
    }
    const frame = this.current;
    if (frame === null) return;
    for (const panel of due.slice(0, this.budget(now, touched))) this.draw(panel, frame);
    this.point(frame, now);
    if (this.texts.due(now)) this.write(frame, now);
    this.frameAt = now;
  }

  /** Pauses the charts at the moment of an event; returns false if this moment has left the history. */
  showEvent({ tick }: EventInfo): boolean {
    const { history } = this.store;
    if (!history.holds(tick)) {
      const kept = history.length === 0 ? "no tick yet" : `${this.store.timeOf(history.first).toFixed(1)} s to ${this.store.timeOf(history.last).toFixed(1)} s`;
      notify("info", `this moment is not in the history of the charts, which has ${kept}`);
      return false;
    }
    this.view.show(this.store.timeOf(tick));
    return true;
  }

  /** The content of the charts, for tests. */
  shown = (): { key: string; title: string; visible: boolean; series: SeriesReading[] }[] => {
    const time = this.cursorTime();
    return this.panels.list.map((panel) => ({ key: panel.spec.key, title: panel.spec.title, visible: panel.visible, series: panel.readings(time) }));
  };

  /** Stretch drawn last, s. */
  get drawn(): Frame | null {
    return this.current;
  }

  /** Time that the charts show beyond now, s: as far as the forecast and the forks reach, but at most a part of the window. */
  private lead(): number {
    const { store } = this;
    const forks = Number.isFinite(store.forks.end) ? (store.forks.end - 1 - Math.max(0, store.lastTick)) * store.tickS : 0;
    return Math.max(store.horizonTicks * store.tickS, Math.min(forks, this.view.windowS * FORKS_PART));
  }

  private cursorTime(): number | null {
    return this.current === null ? null : this.view.cursor(this.current.span);
  }

  /** Number of charts to draw in this frame; after an input of the operator it is twice as large. */
  private budget(now: number, touched: boolean): number {
    const spread = SPREAD_MS[this.software ? "software" : "hardware"] / (touched ? 2 : 1);
    const visible = this.panels.list.filter((panel) => panel.visible).length;
    return Math.max(1, Math.ceil((visible * Math.min(now - this.frameAt, spread)) / spread));
  }

  private outdated(): boolean {
    const { current, store } = this;
    if (current === null || this.drawnEvents !== store.events || this.drawnForks !== store.forks.version) return true;
    return store.history.last !== current.newest && (!this.view.inspecting || current.span[1] >= store.timeOf(current.newest));
  }

  private begin(now: number): void {
    this.round += 1;
    this.roundAt = now;
    this.expired = false;
    this.drawnVersion = this.view.version;
    this.drawnEvents = this.store.events;
    this.drawnForks = this.store.forks.version;
    this.view.leadS = this.lead();
    this.current = takeFrame(this.store, this.view, this.plotWidth(), this.arrangement.zscore, this.arrangement.unmarked);
    this.timeline.refresh(this.current, this.root.clientWidth);
    this.table.show(rangeOf(this.view), this.panels.list);
    this.cursor = NaN;
  }

  private draw(panel: Panel, frame: Frame): void {
    panel.refresh(frame);
    panel.round = this.round;
    panel.point(this.view.cursor(frame.span));
  }

  /** Moves the cursor of every chart to the shared cursor and writes the values there. */
  private point(frame: Frame, now: number): void {
    const time = this.view.cursor(frame.span);
    if (Object.is(time, this.cursor)) return;
    this.cursor = time;
    this.panels.list.filter(({ visible }) => visible).forEach((panel) => panel.point(time));
    if (time !== null) this.write(frame, now);
    this.timeline.point(time);
    this.onCursor(time === null ? null : this.store.tickAt(time));
  }

  /** Writes the values at the cursor, or the newest ones without a cursor. */
  private write(frame: Frame, now: number): void {
    const time = this.view.cursor(frame.span);
    this.panels.list.filter(({ visible }) => visible).forEach((panel) => panel.write(time, now));
  }

  private plotWidth(): number {
    return Math.max(100, this.root.clientWidth - AXIS_WIDTH_PX - RIGHT_PX);
  }

  private sync(anew: boolean): void {
    this.spectrum = this.panels.hasSpectrum();
    this.panels.sync(this.arrangement, this.colors, anew);
    this.menu.rebuild(this.panels.specs(this.arrangement).map(({ key, title }) => ({ key, title })), this.arrangement);
    this.expired = true;
  }

  /** Saves and shows the arrangement after the operator has changed it. */
  private changed(): void {
    save(this.arrangement);
    this.sync(false);
  }

  private chooseRow(row: string): void {
    byId("rows").querySelector<HTMLButtonElement>(`button[value="${row}"]`)?.click();
  }

  private toggleZscore(): void {
    this.arrangement.zscore = !this.arrangement.zscore;
    this.changed();
  }

  private chooseWindow(seconds: number): void {
    this.arrangement.windowS = seconds;
    this.view.setWindow(seconds);
    save(this.arrangement);
  }

  private toDefault(): void {
    Object.assign(this.arrangement, standard());
    this.windows.value = String(this.arrangement.windowS);
    this.view.setWindow(this.arrangement.windowS);
    save(this.arrangement);
    this.rebuild();
  }

  private add(): void {
    const own = addOwn(this.arrangement);
    if (own === null) return notify("warning", "no more charts of your own are possible: remove one first");
    this.changed();
    this.edit(own);
  }

  private edit(own: OwnChart): void {
    byId("charts-options").hidePopover();
    this.picker.open(own, this.store.hello?.channels ?? []);
  }

  private listen(panel: Panel): void {
    if (panel.over === null) return;
    listenPointer(panel.over, this.view, {
      select: (part) => this.panels.list.forEach((other) => other.select(part)),
      hover: (event) => this.hover(event),
      click: (event) => this.click(event),
    });
  }

  private columnX(event: PointerEvent): number {
    return event.clientX - this.root.getBoundingClientRect().left;
  }

  private hover(event: PointerEvent | null): void {
    this.tip.show(event === null ? null : this.timeline.marksAt(this.columnX(event)), event?.clientX ?? 0, event?.clientY ?? 0);
  }

  /** A click on a chart puts the cursor at the pointer; a click on a mark puts it on the mark. */
  private click(event: PointerEvent): void {
    if (this.clickMark(event) || !(this.view.inspecting || this.view.remote !== null)) return;
    const time = this.cursorTime();
    if (time !== null) this.view.moveCursor(time);
  }

  private clickMark(event: PointerEvent): boolean {
    const marks = this.timeline.marksAt(this.columnX(event));
    if (marks === null) return false;
    this.view.show(marks.head.time);
    this.tip.show(null, 0, 0);
    return true;
  }

  /** Tells screen readers the values at the cursor once it rests: those of the chart with the focus, else of the first chart. */
  speakSoon(): void {
    clearTimeout(this.speech);
    this.speech = window.setTimeout(() => {
      const time = this.cursorTime();
      const panel = this.panels.list.find(({ root }) => root.contains(document.activeElement)) ?? this.panels.list[0];
      if (time !== null && panel !== undefined) setText(byId("chart-speech"), `${time.toFixed(2)} s. ${panel.sentence(time)}`);
    }, SPEAK_AFTER_MS);
  }

  private picture(): void {
    this.expired = true;
    const now = performance.now();
    this.begin(now);
    const frame = this.current;
    if (frame === null) return;
    this.panels.list.forEach((panel) => this.draw(panel, frame));
    this.panels.list.forEach((panel) => panel.write(this.view.cursor(frame.span), now));
    // uPlot draws after the current task, so the picture is taken later.
    setTimeout(() => savePng(this.store, frame, this.panels.list, this.timeline.picture(), this.colors), 0);
  }
}
