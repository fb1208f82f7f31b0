// The bar of a mirrored recording: its description, the time of playback, and the slider and keys that seek. A simulated flight
// has no such bar. Pause, step and speed stand in the top bar.
import type { Store } from "../data/store";
import type { ClientMessage, MirrorInfo, StateInfo, TwinInfo } from "../protocol";
import { commands } from "./commands";
import { byId, element, setText } from "./dom";
import { hang } from "./popover";
import { Throttle } from "./throttle";

/** The least time between two seeks of a dragged slider, ms. At each seek the shadow flies the ten seconds before the target. */
const SEEK_EVERY_MS = 150;
/** A time after the end of any stream, s. The server seeks the newest tick instead. */
const NEWEST_S = 1e6;
/** The server's name for the phase in which a stream sends nothing. */
const STREAM_LOST = "stream lost";
/** Time by which an arrow key seeks, s. */
const ARROW_S = 0.1;

/** A stretch of the recording, s. */
export interface Stretch {
  from: number;
  to: number;
}

export class MirrorBar {
  private readonly root = byId("mirror-bar");
  private readonly slider = byId<HTMLInputElement>("mirror-time");
  private readonly throttle = new Throttle(SEEK_EVERY_MS, (tS) => this.send({ type: "seek", t_s: tS }));
  private readonly loopButton = byId("mirror-loop");
  private dragging = false;
  /** The result of the twin that is shown. */
  private shown: TwinInfo | null = null;
  /** The stretch that is played in a loop; null without a loop. */
  private loop: Stretch | null = null;

  /** `marked` returns the stretch that is marked on the charts; null if there is none. */
  constructor(
    private readonly store: Store,
    private readonly send: (request: ClientMessage) => void,
    private readonly marked: () => Stretch | null,
  ) {
    this.slider.addEventListener("input", () => {
      this.dragging = true;
      this.throttle.ask(this.slider.valueAsNumber);
      this.label(this.slider.valueAsNumber);
    });
    this.slider.addEventListener("change", () => {
      this.dragging = false;
      this.throttle.flush();
    });
    byId("mirror-start").addEventListener("click", () => this.seek(0));
    byId("mirror-back").addEventListener("click", () => this.by(-this.store.tickS));
    this.loopButton.addEventListener("click", () => this.toggleLoop());
    hang(byId("mirror-panel"), byId("mirror-about"));
    const when = (): boolean => this.info !== null;
    commands.register(
      { id: "mirror.back", group: "Recording", description: "go back by 100 ms", keys: ["ArrowLeft"], action: () => this.by(-ARROW_S), when: () => when() && !this.flying, repeats: true },
      { id: "mirror.tickBack", group: "Recording", description: "go back by one tick", keys: ["Ctrl+ArrowLeft"], action: () => this.by(-this.store.tickS), when, repeats: true },
      { id: "mirror.loop", group: "Recording", description: "loop over the range from I to O, or over the whole recording", keys: ["Shift+O"], action: () => this.toggleLoop(), when },
      { id: "mirror.start", group: "Recording", description: "go to the start of the recording", keys: ["Home"], action: () => this.seek(0), when },
      { id: "mirror.end", group: "Recording", description: "go to the end of the recording", keys: ["End"], action: () => this.seek(this.endS), when },
    );
  }

  /** Takes a new `hello`. */
  rebuild(): void {
    const { info } = this;
    this.root.hidden = info === null;
    document.body.dataset["mode"] = info === null ? "fly" : "mirror";
    if (info === null) {
      this.loop = null;
      return;
    }
    this.showLoop();
    setText(byId("mirror-vehicle"), `${info.vehicle} · ${info.file}`);
    this.slider.max = String(info.duration_s);
    this.slider.step = String(this.store.tickS);
    byId("mirror-facts").replaceChildren(...facts(info).flatMap(([name, text]) => [element("dt", { textContent: name }), element("dd", { textContent: text })]));
  }

  /** Shows the time of playback, and restarts a loop at its end; called a few times a second. */
  readings(): void {
    this.beside();
    if (this.info === null || this.dragging) return;
    const tick = this.store.lastTick >= 0 ? this.store.lastTick : (this.store.state?.tick ?? 0);
    const tS = tick * this.store.tickS;
    // A stream has no end, so the slider reaches from its start to the newest tick.
    if (this.info.live && tS > Number(this.slider.max)) this.slider.max = String(tS);
    this.slider.value = String(tS);
    this.label(tS);
    if (this.loop === null) return;
    if (tS >= this.loop.to - this.store.tickS && this.flying) this.seek(this.loop.from);
    else if (this.atEnd(tS)) this.playFrom(this.loop.from);
  }

  /** Shows how far the twin, which started from the state of the flight half a second ago, has departed from the flight. */
  private beside(): void {
    const twin = this.store.state?.twin ?? null;
    if (this.info === null || twin === null || twin === this.shown) return;
    this.shown = twin;
    const badge = byId("mirror-twin");
    badge.dataset["light"] = twin.light ?? "unknown";
    badge.title = `${twin.says}; ${twin.horizon_s.toFixed(1)} s after it started from the state of the flight. The errors of each axis stand under About…`;
    setText(badge, verdict(twin));
    const gate = byId("mirror-gate");
    gate.dataset["light"] = twin.gate_passed === null ? "unknown" : twin.gate_passed ? "valid" : "doubtful";
    gate.title = `The forecast of the residual, since the last jump: ${twin.gate}`;
    setText(gate, gateText(twin));
    const head = ["axis", "twin", "twin with residual", "coasting"].map((textContent) => element("th", { textContent }));
    byId("mirror-axes").replaceChildren(row(head), ...cells(twin).map((texts) => row(texts.map((textContent) => element("td", { textContent })))));
  }

  private toggleLoop(): void {
    this.loop = this.loop === null ? (this.marked() ?? { from: 0, to: this.info?.duration_s ?? 0 }) : null;
    this.showLoop();
  }

  private showLoop(): void {
    const { loop, loopButton } = this;
    loopButton.ariaPressed = String(loop !== null);
    setText(loopButton, loop === null ? "Loop" : `Loop ${loop.from.toFixed(1)}–${loop.to.toFixed(1)} s`);
  }

  /** Whether the recording has been played to its end and is paused there. */
  private atEnd(tS: number): boolean {
    return this.store.state?.phase === "paused" && this.info?.live === false && tS >= (this.info?.duration_s ?? Infinity) - 2 * this.store.tickS;
  }

  private playFrom(tS: number): void {
    this.seek(tS);
    this.send({ type: "pause", paused: false });
  }

  private label(tS: number): void {
    const lost = this.store.state?.task_phase === STREAM_LOST;
    const end = this.info?.live === true ? (lost ? STREAM_LOST.toUpperCase() : "live") : `${(this.info?.duration_s ?? 0).toFixed(1)} s`;
    setText(byId("mirror-now"), `${tS.toFixed(2)} / ${end}`);
    this.slider.ariaValueText = `${tS.toFixed(1)} seconds`;
  }

  private by(deltaS: number): void {
    if (this.flying) this.send({ type: "pause", paused: true });
    this.seek(this.store.lastTick * this.store.tickS + deltaS);
  }

  private seek(tS: number): void {
    this.send({ type: "seek", t_s: Math.min(Math.max(tS, 0), this.endS) });
  }

  /** The last time to which the bar can seek, s. */
  private get endS(): number {
    return this.info?.live === true ? NEWEST_S : (this.info?.duration_s ?? 0);
  }

  private get info(): MirrorInfo | null {
    return this.store.hello?.mirror ?? null;
  }

  private get flying(): boolean {
    const phase: StateInfo["phase"] | undefined = this.store.state?.phase;
    return phase === "flying";
  }
}

function row(children: HTMLElement[]): HTMLElement {
  const tr = element("tr", {});
  tr.append(...children);
  return tr;
}

const LIGHTS: Record<NonNullable<TwinInfo["light"]>, string> = { valid: "✓ twin holds", doubtful: "≈ twin doubtful", invalid: "✗ twin does not hold" };

/** The validity of the twin in words, so that it never depends on the colour alone. */
export function verdict(twin: TwinInfo): string {
  return twin.light === null ? "twin: unknown" : LIGHTS[twin.light];
}

/** The gate of the predictor in words: what it is not better than stands in the bar, the rest in the badge's title. */
export function gateText(twin: TwinInfo): string {
  if (twin.gate_passed === null) return "forecast: not scored";
  if (twin.gate_passed) return "✓ forecast better than persistence and mean";
  return `≈ forecast ${twin.gate.slice(Math.max(twin.gate.indexOf("not better"), 0))}`;
}

/** One line per axis with the errors of the twin, of the twin with residual and of coasting against the flight, mm or mrad. */
export function cells(twin: TwinInfo): string[][] {
  return twin.axes.map(({ row: name, twin: bare, with_residual, coasting }) => {
    const unit = ["x", "y", "z"].includes(name) ? "mm" : "mrad";
    return [name, ...[bare, with_residual, coasting].map((miss) => `${(1e3 * miss).toFixed(0)} ${unit}`)];
  });
}

/** Name and text of each line about the recording in the bar's panel. */
export function facts(info: MirrorInfo): [string, string][] {
  return [
    ["solid", `the real flight; ${info.stand_in}`],
    ["ghost", info.ghost],
    ["predictor", `${info.predictor}; it runs in shadow and moves nothing`],
    ["force", info.force],
    ["unknown", info.unknown_rows.length === 0 ? "nothing" : `residual of ${info.unknown_rows.join(", ")}: this recording does not contain it, so it is not shown`],
    ["map", info.map],
    ...info.notes.map((note): [string, string] => ["note", note]),
  ];
}
