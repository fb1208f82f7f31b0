// The bar that an operator reads first. It tells whether the flight runs, whether it is well, and whether the data are fresh.
import type { Store } from "../data/store";
import { clockMs, type Link } from "../link/link";
import type { StateInfo } from "../protocol";
import { byId, option, setText } from "./dom";

/** The only verdict that means success. */
const COMPLETED = "completed";
const SPEEDS = [0.01, 0.1, 0.25, 0.5, 1, 2, 5, 10, 20];
const PHASES: Record<StateInfo["phase"], { text: string; tone: string }> = {
  flying: { text: "● flying", tone: "good" },
  paused: { text: "❚❚ paused", tone: "warn" },
  ended: { text: "■ ended", tone: "" },
};

/** What stands in place of the phase while the page shows the past. */
const PAST = { text: "◀◀ past", tone: "warn" };

export class TopBar {
  private readonly scenario = byId<HTMLSelectElement>("scenario");
  private readonly speed = byId<HTMLSelectElement>("speed");
  private readonly pauseButton = byId("pause");
  private readonly restartButton = byId("restart");

  constructor(
    private readonly store: Store,
    private readonly link: Link,
  ) {
    this.speed.append(...SPEEDS.map((value) => option(String(value), `${value}×`, value === 1)), option("max", "max"));
    this.speed.addEventListener("change", () => link.send({ type: "speed", value: this.speed.value === "max" ? null : Number(this.speed.value) }));
    this.pauseButton.addEventListener("click", () => this.togglePause());
    byId("step").addEventListener("click", () => this.step());
    this.restartButton.addEventListener("click", () => this.restart());
    this.scenario.addEventListener("change", () => this.arm());
  }

  togglePause(): void {
    this.link.send({ type: "pause", paused: this.store.state?.phase === "flying" });
  }

  /** Flies `ticks` and pauses. */
  step(ticks = 1): void {
    if (this.store.state?.phase === "flying") this.link.send({ type: "pause", paused: true });
    this.link.send({ type: "step", ticks });
  }

  /** Restarts the flight, or starts the scenario that was chosen meanwhile, with `seed`; null keeps the seed in use. */
  restart(seed: number | null = null): void {
    const chosen = this.scenario.value;
    const scenario = chosen === "" || chosen === this.store.state?.scenario ? null : chosen;
    this.link.send({ type: "restart", seed, scenario });
  }

  /** Chooses the speed that stands `by` places further in the list. */
  faster(by: number): void {
    const values = SPEEDS.filter((value) => Math.sign(value - this.speedNow) === by);
    const next = by > 0 ? values[0] : values.at(-1);
    if (next !== undefined) this.link.send({ type: "speed", value: next });
  }

  private get speedNow(): number {
    return this.store.state?.speed ?? Infinity;
  }

  rebuild(): void {
    const { hello, state } = this.store;
    const known = hello?.scenarios ?? [];
    const current = state?.scenario ?? hello?.scenario ?? "";
    const listed = known.some(({ name }) => name === current) ? known : [{ name: current, title: current }, ...known];
    this.scenario.replaceChildren(...listed.map(({ name, title }) => Object.assign(option(name, name, name === current), { title })));
    this.arm();
    this.show();
  }

  /** Shows the newest `state`, and of a past moment what was true then. */
  show(): void {
    const state = this.store.state;
    if (state === null) return;
    const past = this.store.playhead !== null;
    const { text, tone } = past ? PAST : PHASES[state.phase];
    badge("phase", text, tone);
    byId("phase").title = past ? `The page shows the past. The flight itself: ${state.phase}` : "";
    const verdict = byId("verdict");
    verdict.hidden = state.verdict === null || past;
    if (state.verdict !== null) badge("verdict", verdictText(state.verdict), state.verdict === COMPLETED ? "good" : "bad");
    const detail = (past ? null : state.reason) ?? this.store.phaseText();
    setText(byId("task-phase"), detail);
    byId("task-phase").title = detail;
    const flying = state.phase === "flying";
    this.pauseButton.ariaLabel = flying ? "Pause" : "Continue";
    setText(this.pauseButton.firstElementChild as HTMLElement, flying ? "❚❚" : "▶");
    const speed = state.speed === null ? "max" : String(state.speed);
    if (![...this.speed.options].some(({ value }) => value === speed)) this.speed.append(option(speed, `${speed}×`));
    if (document.activeElement !== this.speed) this.speed.value = speed;
    setText(byId("rtf"), `${state.real_time_factor.toFixed(state.real_time_factor >= 10 ? 0 : 2)}×`);
    document.title = `${state.phase} · ${state.scenario} · twin`;
  }

  /** Writes the values that change all the time; called a few times a second. */
  readings(stale: boolean): void {
    const { health } = this.link;
    const now = clockMs();
    const flying = this.store.state?.phase === "flying";
    const { playhead } = this.store;
    const time = playhead === null ? (this.store.newest?.tSim ?? this.store.state?.t_s) : this.store.timeOf(playhead);
    setText(byId("time"), time === undefined ? "–" : `${time.toFixed(1)} s`);
    const age = health.ageMs(now, flying);
    byId("link").dataset["tone"] = stale ? "bad" : "good";
    setText(byId("age"), Number.isFinite(age) ? ageText(age) : "–");
    const round = Number.isFinite(health.roundTripMs) ? `${health.roundTripMs.toFixed(1)} ms` : "unknown";
    byId("link").title = `Link health (L): round trip ${round}; ${health.gapTicks} ticks lost in ${health.gapCount} gaps`;
  }

  private arm(): void {
    const other = this.scenario.value !== this.store.state?.scenario && this.store.state !== null;
    this.restartButton.classList.toggle("armed", other);
    setText(this.restartButton, other ? "Start" : "Restart");
  }
}

function badge(id: string, text: string, tone: string): void {
  const target = byId(id);
  setText(target, text);
  target.dataset["tone"] = tone;
}

function verdictText(verdict: string): string {
  return `${verdict === COMPLETED ? "✓" : "✕"} ${verdict}`;
}

function ageText(ms: number): string {
  return ms < 1000 ? `${Math.round(ms / 10) * 10} ms` : `${(ms / 1000).toFixed(ms < 10_000 ? 1 : 0)} s`;
}
