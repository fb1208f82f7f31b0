// The wall-clock time of each stage of a tick: a small stacked bar in the top bar, and the numbers in a panel.
import type { StateInfo } from "../protocol";
import { byId, element, setText } from "./dom";
import { hang, isOpen } from "./popover";

/** Colours of the stages in order. With more stages the colours repeat; the panel names each stage. */
const COLORS = [2, 1, 3, 4, 5, 7, 6, 8].map((place) => `series-${place}`);
const MS_PER_S = 1000;

type Stages = StateInfo["stages"];

export class Timing {
  private readonly panel = byId("timing-panel");
  private state: StateInfo | null = null;
  private tickMs = 10;

  constructor() {
    hang(this.panel, byId("timing-open"), () => this.table());
  }

  show(state: StateInfo, tickS: number): void {
    // While the flight is paused there are no new times, so the last ones stay.
    const kept = totalMs(state.stages) > 0 ? state.stages : (this.state?.stages ?? state.stages);
    this.state = { ...state, stages: kept };
    this.tickMs = tickS * MS_PER_S;
    const total = totalMs(kept);
    byId("stage-bar").replaceChildren(...segments(kept, Math.max(total, this.tickMs)));
    byId("timing-open").title = total === 0 ? "Real-time factor. No tick has been timed yet." : `The server computes a tick of ${this.tickMs.toFixed(0)} ms in ${total.toFixed(2)} ms`;
    if (isOpen(this.panel)) this.table();
  }

  private table(): void {
    if (this.state === null) return;
    const { stages, speed, real_time_factor: reached } = this.state;
    const total = totalMs(stages);
    setText(byId("timing-speed"), `${reached.toFixed(2)}× real time, requested: ${speed === null ? "as fast as possible" : `${speed}×`}`);
    byId("timing-bar").replaceChildren(...segments(stages, Math.max(total, this.tickMs)));
    byId("timing-rows").replaceChildren(
      ...stages.map(({ name, ms }, index) => row(name.replaceAll("_", " "), ms, this.tickMs, swatch(index))),
      row("together", total, this.tickMs, null),
    );
    byId("timing-none").hidden = total > 0;
  }
}

function totalMs(stages: Stages): number {
  return stages.reduce((sum, { ms }) => sum + ms, 0);
}

/** One segment per stage; the rest of `fullMs` stays empty. */
function segments(stages: Stages, fullMs: number): HTMLElement[] {
  return stages.map(({ ms }, index) => {
    const part = swatch(index);
    part.style.width = `${(100 * ms) / fullMs}%`;
    return part;
  });
}

function swatch(index: number): HTMLElement {
  const made = element("i", { ariaHidden: "true" });
  made.style.background = `var(--${COLORS[index % COLORS.length] ?? "muted"})`;
  return made;
}

function row(name: string, ms: number, tickMs: number, mark: HTMLElement | null): HTMLElement {
  return element("tr", {}, [
    element("th", { scope: "row" }, [...(mark === null ? [] : [mark]), name]),
    element("td", { textContent: `${ms.toFixed(3)} ms` }),
    element("td", { textContent: `${((100 * ms) / tickMs).toFixed(1)} %` }),
  ]);
}
