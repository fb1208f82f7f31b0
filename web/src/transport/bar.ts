// The timeline at the foot of the page: the controls of the playhead, and lanes over the whole flight on which it is dragged.
import type { Store } from "../data/store";
import { Beat } from "../panels/beat";
import { byId, element, option, setText } from "../panels/dom";
import { emptied } from "../plots/canvasPanel";
import { markKind } from "../plots/clusters";
import { type ChartColors, readColors } from "../plots/colors";
import { marksOf } from "../plots/frame";
import type { Span, View } from "../plots/view";
import { type Lanes, lanesOf, stopsOf } from "./lanes";
import { drawLanes, LANES_PX, NAMES_PX, RIGHT_PX } from "./lanesPen";
import { behindText, parseTime, timeText } from "./timeText";
import type { Transport } from "./transport";

/** The timeline of a flight that goes on grows by steps of this length, so that it stands still in between, s. */
const GROWTH_S = 30;
/** The least time between two drawings of the lanes, ms. */
const DRAW_EVERY_MS = 400;
/** A mark within this distance of the pointer is told, px. */
const REACH_PX = 7;
const MOST_LINES = 4;
/** A stop within this distance of the playhead is where the playhead stands, s. */
const SAME_STOP_S = 0.006;
const MAXIMAL = "max";

export class TimeBar {
  private readonly lanes = byId("lanes");
  private readonly canvas = element("canvas", { ariaHidden: "true" });
  private readonly head = element("i", { className: "playhead" });
  private readonly window = element("i", { className: "in-view" });
  private readonly newest = element("i", { className: "newest" });
  private readonly tip = byId("lanes-tip");
  private readonly field = byId<HTMLInputElement>("at");
  private readonly play = byId("play");
  private readonly liveButton = byId<HTMLButtonElement>("to-live");
  private readonly speeds = byId<HTMLSelectElement>("play-speed");
  private readonly loopButton = byId("loop");
  private readonly texts = new Beat();
  private colors: ChartColors = readColors();
  private content: Lanes | null = null;
  private width = 0;
  private drawnAt = -Infinity;
  /** Time at which the playhead stands on the timeline, s. */
  private placedS = NaN;
  /** Time to which the pointer has dragged the playhead since the last frame, s. */
  private dragged: number | null = null;

  constructor(
    private readonly store: Store,
    private readonly view: View,
    private readonly transport: () => Transport,
  ) {
    this.lanes.replaceChildren(this.canvas, this.window, this.newest, this.head);
    this.lanes.style.height = `${LANES_PX}px`;
    new ResizeObserver(() => {
      this.width = this.lanes.clientWidth;
      this.drawnAt = -Infinity;
    }).observe(this.lanes);
    this.listen();
  }

  /** Takes another flight or another transport. */
  rebuild(): void {
    this.speeds.replaceChildren(...this.transport().speeds.map((speed) => option(speed === null ? MAXIMAL : String(speed), speed === null ? MAXIMAL : `${speed}×`)));
    this.drawnAt = -Infinity;
  }

  recolor(): void {
    this.colors = readColors();
    this.drawnAt = -Infinity;
  }

  /** Goes to the event before (`by` is -1) or after (1) the playhead. */
  toEvent(by: -1 | 1): void {
    const transport = this.transport();
    const stops = stopsOf(this.store, this.view).filter((time) => by * (time - transport.timeS) > SAME_STOP_S);
    const next = by > 0 ? stops[0] : stops.at(-1);
    if (next !== undefined) transport.seek(next);
    else if (by > 0) transport.toNewest();
  }

  /** Puts the keyboard into the field of the time. */
  typeTime(): void {
    this.field.focus();
    this.field.select();
  }

  /** Called in each frame, `now` in ms. */
  frame(now: number): void {
    const transport = this.transport();
    if (this.dragged !== null) {
      transport.seek(this.dragged);
      this.dragged = null;
    }
    if (now - this.drawnAt >= DRAW_EVERY_MS) this.draw(now);
    // Every change makes the browser paint the whole page, so what moves by itself moves with the texts; what the operator moves follows at once.
    const beat = this.texts.due(now);
    const led = !transport.playing && (transport.past || !transport.live);
    if (beat || (led && transport.timeS !== this.placedS)) this.place(transport);
    if (beat) this.readings(transport);
  }

  /** The content of the timeline, for tests. */
  get shown(): { span: Span; phases: string[]; marks: string[][]; most: number } {
    const { span, phases, marks, ribbon } = this.content ?? { span: [0, 0] as Span, phases: [], marks: [], ribbon: [] };
    const known = ribbon.filter((ratio) => !Number.isNaN(ratio));
    return { span, phases: phases.map(({ text }) => text), marks: marks.map((lane) => lane.map(({ kind }) => kind)), most: Math.max(0, ...known) };
  }

  private get plotPx(): number {
    return Math.max(1, this.width - NAMES_PX - RIGHT_PX);
  }

  private span(): Span {
    const { oldestS, newestS, live } = this.transport();
    const ended = this.store.state?.phase === "ended";
    const end = live && !ended ? Math.ceil((newestS + 1) / GROWTH_S) * GROWTH_S : newestS;
    return [oldestS, Math.max(end, oldestS + 1)];
  }

  private draw(now: number): void {
    this.drawnAt = now;
    const pen = emptied(this.canvas, [this.width, LANES_PX]);
    if (pen === null || this.width === 0) return;
    this.content = lanesOf(this.store, this.view, this.span(), this.plotPx);
    drawLanes(pen, this.content, this.width, this.colors);
  }

  private xOf(time: number): number {
    const [from, to] = this.content?.span ?? [0, 1];
    return NAMES_PX + Math.min(1, Math.max(0, (time - from) / (to - from))) * this.plotPx;
  }

  private timeAt(event: PointerEvent): number {
    const [from, to] = this.content?.span ?? [0, 1];
    const part = (event.clientX - this.lanes.getBoundingClientRect().left - NAMES_PX) / this.plotPx;
    const { oldestS, newestS } = this.transport();
    return Math.min(newestS, Math.max(oldestS, from + Math.min(1, Math.max(0, part)) * (to - from)));
  }

  private place(transport: Transport): void {
    this.placedS = transport.timeS;
    this.head.style.transform = `translateX(${this.xOf(transport.timeS).toFixed(1)}px)`;
    this.newest.style.transform = `translateX(${this.xOf(transport.newestS).toFixed(1)}px)`;
    const [from, to] = this.view.span().map((time) => this.xOf(Math.min(time, transport.newestS))) as Span;
    this.window.style.transform = `translateX(${from.toFixed(1)}px)`;
    this.window.style.width = `${Math.max(2, to - from).toFixed(1)}px`;
  }

  private readings(transport: Transport): void {
    const { timeS, newestS, past, playing, live, loop } = transport;
    if (document.activeElement !== this.field) this.field.value = timeText(timeS);
    this.lanes.ariaValueNow = timeS.toFixed(2);
    this.lanes.setAttribute("aria-valuemax", newestS.toFixed(2));
    this.lanes.ariaValueText = `${timeS.toFixed(2)} seconds${past ? `, ${(newestS - timeS).toFixed(1)} behind the flight` : ""}`;
    setText(byId("behind"), past ? behindText(newestS - timeS) : live ? "live" : `/ ${timeText(newestS)}`);
    byId("behind").dataset["when"] = past ? "past" : live ? "live" : "whole";
    const moves = playing || (live && !past);
    setText(this.play.firstElementChild as HTMLElement, moves ? "❚❚" : "▶");
    this.play.ariaLabel = moves ? "Hold this moment" : "Play from here";
    this.liveButton.hidden = !live;
    this.liveButton.disabled = live && !past && !this.mirrored;
    const speed = transport.speed === null || !Number.isFinite(transport.speed) ? MAXIMAL : String(transport.speed);
    if (document.activeElement !== this.speeds) this.speeds.value = speed;
    this.loopButton.ariaPressed = String(loop !== null);
    setText(this.loopButton, loop === null ? "Loop" : `${loop.from.toFixed(1)}–${loop.to.toFixed(1)} s`);
  }

  private get mirrored(): boolean {
    return (this.store.hello?.mirror ?? null) !== null;
  }

  private listen(): void {
    const click = (id: string, act: (transport: Transport) => void): void => byId(id).addEventListener("click", () => act(this.transport()));
    click("to-start", (transport) => transport.seek(transport.oldestS));
    click("tick-back", (transport) => transport.step(-this.store.tickS));
    click("play", (transport) => transport.toggle());
    click("tick-on", (transport) => transport.step(this.store.tickS));
    click("to-live", (transport) => transport.toNewest());
    click("loop", (transport) => transport.toggleLoop());
    byId("event-before").addEventListener("click", () => this.toEvent(-1));
    byId("event-after").addEventListener("click", () => this.toEvent(1));
    this.speeds.addEventListener("change", () => this.transport().setSpeed(this.speeds.value === MAXIMAL ? null : Number(this.speeds.value)));
    this.field.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.typed();
      if (event.key === "Enter" || event.key === "Escape") this.field.blur();
    });
    let down = false;
    this.lanes.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      down = true;
      this.lanes.setPointerCapture(event.pointerId);
      this.dragged = this.timeAt(event);
    });
    this.lanes.addEventListener("pointermove", (event) => {
      if (down) this.dragged = this.timeAt(event);
      this.tell(event);
    });
    const end = (): void => void (down = false);
    this.lanes.addEventListener("pointerup", end);
    this.lanes.addEventListener("pointercancel", end);
    this.lanes.addEventListener("pointerleave", () => (this.tip.hidden = true));
  }

  private typed(): void {
    const transport = this.transport();
    const time = parseTime(this.field.value, transport.newestS);
    if (time !== null) transport.seek(Math.min(transport.newestS, Math.max(transport.oldestS, time)));
  }

  /** Tells the time under the pointer, and the marks near it. */
  private tell(event: PointerEvent): void {
    const time = this.timeAt(event);
    const [from, to] = this.content?.span ?? [0, 1];
    const reach = (REACH_PX / this.plotPx) * (to - from);
    const near = marksOf(this.store, this.view, this.store.tickAt(time - reach), this.store.tickAt(time + reach));
    const phase = this.content?.phases.find(({ span }) => time >= span[0] && time < span[1]);
    const lines = near.slice(0, MOST_LINES).map(({ kind, text, time: at }) => element("p", { textContent: `${markKind(kind).icon} ${at.toFixed(2)} s ${text}` }));
    if (near.length > MOST_LINES) lines.push(element("p", { className: "muted", textContent: `and ${near.length - MOST_LINES} more` }));
    this.tip.replaceChildren(element("p", {}, [element("b", { textContent: `${timeText(time)} s` }), phase === undefined ? "" : ` ${phase.text}`]), ...lines);
    this.tip.hidden = false;
    const half = this.tip.offsetWidth / 2;
    const x = event.clientX - this.lanes.getBoundingClientRect().left + this.lanes.offsetLeft;
    this.tip.style.left = `${Math.min(window.innerWidth - this.tip.offsetWidth - 6, Math.max(6, x - half))}px`;
  }
}
