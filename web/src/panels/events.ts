// The event log of the flight. It follows the newest line unless the operator has scrolled back. Choosing a line shows its moment
// on the charts. The line at the cursor of the charts is marked.
import { eventKind } from "../data/eventKinds";
import { joined } from "../data/gainEvents";
import type { EventInfo } from "../protocol";
import { byId, element } from "./dom";

const KEPT_LINES = 500;
/** Other events come between the two of a drag; so many lines are looked at. */
const LINES_OF_A_DRAG = 12;
const AT_THE_END_PX = 24;

interface Line {
  event: EventInfo;
  item: HTMLLIElement;
}

export class EventLog {
  private readonly list = byId("events");
  private lines: Line[] = [];
  private at: HTMLLIElement | null = null;
  private firstHeld = -1;
  /** Whether the list follows the newest line. It stops when the operator scrolls back, but not when the list changes its size. */
  private following = true;

  /** `choose` shows the moment of an event on the charts. */
  constructor(private readonly choose: (event: EventInfo) => void) {
    // While a line is marked, the list scrolls by itself to show it.
    this.list.addEventListener("scroll", () => (this.following = this.at === null ? this.atTheEnd() : this.following));
    this.list.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.follow()).observe(this.list);
  }

  rebuild(events: EventInfo[]): void {
    this.list.replaceChildren();
    this.following = true;
    this.lines = [];
    this.at = null;
    this.firstHeld = -1;
    if (events.length === 0) this.list.append(element("li", { className: "empty", textContent: "No events yet." }));
    this.add(events);
  }

  add(events: EventInfo[]): void {
    if (events.length === 0) return;
    this.list.querySelector(".empty")?.remove();
    for (const told of events) {
      const event = this.takeBack(told) ?? told;
      const item = line(event, () => this.choose(event));
      this.list.append(item);
      this.lines.push({ event, item });
    }
    while (this.lines.length > KEPT_LINES) this.lines.shift()?.item.remove();
    this.follow();
  }

  /** Marks the last event at or before the `tick` of the cursor; null removes the mark. */
  mark(tick: number | null): void {
    const item = (tick === null ? undefined : this.lines.filter(({ event }) => event.tick <= tick).at(-1)?.item) ?? null;
    if (item === this.at) return;
    this.at?.removeAttribute("aria-current");
    this.at = item;
    if (item === null) return this.follow();
    item.setAttribute("aria-current", "time");
    item.scrollIntoView({ block: "nearest" });
  }

  /** Marks the events before the oldest tick of the charts' history as gone. */
  markGone(firstHeld: number): void {
    if (firstHeld === this.firstHeld || Number.isNaN(firstHeld)) return;
    this.firstHeld = firstHeld;
    for (const { event, item } of this.lines) {
      const gone = event.tick < firstHeld;
      if (item.classList.contains("gone") !== gone) {
        item.classList.toggle("gone", gone);
        item.title = gone ? `tick ${event.tick}: not in the history of the charts` : `tick ${event.tick}: show it on the charts`;
      }
    }
  }

  /** Takes the line of the same drag of a slider back, and returns the event of the whole drag; null if `next` belongs to no drag. */
  private takeBack(next: EventInfo): EventInfo | null {
    for (const line of this.lines.slice(-LINES_OF_A_DRAG)) {
      const both = joined(line.event, next);
      if (both === null) continue;
      line.item.remove();
      this.lines.splice(this.lines.indexOf(line), 1);
      return both;
    }
    return null;
  }

  private key(event: KeyboardEvent): void {
    const by = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
    if (by === 0) return;
    event.preventDefault();
    const buttons = this.lines.map(({ item }) => item.querySelector("button"));
    const now = buttons.findIndex((button) => button === document.activeElement);
    const next = now < 0 ? (by > 0 ? 0 : buttons.length - 1) : Math.min(buttons.length - 1, Math.max(0, now + by));
    buttons[next]?.focus();
  }

  private follow(): void {
    if (this.at === null && this.following) this.list.scrollTop = this.list.scrollHeight;
  }

  private atTheEnd(): boolean {
    return this.list.scrollHeight - this.list.scrollTop - this.list.clientHeight < AT_THE_END_PX;
  }
}

function line({ t_s, kind, text, tick }: EventInfo, choose: () => void): HTMLLIElement {
  const known = eventKind(kind);
  const icon = element("i", { textContent: known.icon, ariaHidden: "true" });
  const button = element("button", { tabIndex: -1 }, [
    element("span", { className: "when", textContent: `${t_s.toFixed(2)} s` }),
    element("span", { className: "kind" }, [icon, known.label]),
    element("span", { textContent: text }),
  ]);
  button.addEventListener("click", choose);
  const item = element("li", { title: `tick ${tick}: show it on the charts` }, [button]);
  if (known.tone !== undefined) item.dataset["tone"] = known.tone;
  return item;
}
