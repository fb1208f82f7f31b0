// The log of the flight. It follows the newest line unless the operator scrolled back.
import type { EventInfo } from "../protocol";
import { byId, element } from "./dom";

interface Kind {
  icon: string;
  label: string;
  tone?: "good" | "warn" | "bad";
}

const KINDS: Record<string, Kind> = {
  phase: { icon: "▸", label: "phase" },
  grasp: { icon: "⊓", label: "grasp", tone: "good" },
  release: { icon: "⊔", label: "release", tone: "good" },
  retry: { icon: "⟲", label: "retry", tone: "warn" },
  reset: { icon: "↺", label: "reset", tone: "warn" },
  gain: { icon: "◆", label: "gain" },
  disturbance: { icon: "≈", label: "disturbance", tone: "warn" },
  fault: { icon: "▲", label: "fault", tone: "bad" },
  verdict: { icon: "■", label: "verdict" },
};
/** Changes of one gain this close together are one drag, s. */
const DRAG_WITHIN_S = 1;
const KEPT_LINES = 200;
const AT_THE_END_PX = 24;

export class EventLog {
  private readonly list = byId("events");
  private last: EventInfo | null = null;
  /** Until the operator scrolls back; a change of the list's size is not the operator. */
  private following = true;

  constructor() {
    this.list.addEventListener("scroll", () => (this.following = this.atTheEnd()));
    new ResizeObserver(() => this.follow()).observe(this.list);
  }

  rebuild(events: EventInfo[]): void {
    this.list.replaceChildren();
    this.following = true;
    this.last = null;
    if (events.length === 0) this.list.append(element("li", { className: "empty", textContent: "No events yet." }));
    this.add(events);
  }

  add(events: EventInfo[]): void {
    if (events.length === 0) return;
    this.list.querySelector(".empty")?.remove();
    for (const event of events) {
      if (this.last !== null && continues(this.last, event)) this.list.lastElementChild?.remove();
      this.list.append(line(event));
      this.last = event;
    }
    while (this.list.childElementCount > KEPT_LINES) this.list.firstElementChild?.remove();
    this.follow();
  }

  private follow(): void {
    if (this.following) this.list.scrollTop = this.list.scrollHeight;
  }

  private atTheEnd(): boolean {
    return this.list.scrollHeight - this.list.scrollTop - this.list.clientHeight < AT_THE_END_PX;
  }
}

/** A slider being dragged gives one line, not one per position. */
export function continues(last: EventInfo, next: EventInfo): boolean {
  const stem = (text: string): string => text.replace(/\s[-−]?\d.*$/s, "");
  return last.kind === "gain" && next.kind === "gain" && next.t_s - last.t_s < DRAG_WITHIN_S && stem(last.text) === stem(next.text);
}

function line({ t_s, kind, text, tick }: EventInfo): HTMLLIElement {
  const known = KINDS[kind] ?? { icon: "·", label: kind };
  const icon = element("i", { textContent: known.icon, ariaHidden: "true" });
  const item = element("li", { title: `tick ${tick}` }, [
    element("span", { className: "when", textContent: `${t_s.toFixed(2)} s` }),
    element("span", { className: "kind" }, [icon, known.label]),
    element("span", { textContent: text }),
  ]);
  if (known.tone !== undefined) item.dataset["tone"] = known.tone;
  return item;
}
