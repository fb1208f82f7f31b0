// What the adapter does and which margins the vehicle has, at the shown moment, in words and numbers.
import type { Store } from "../data/store";
import { byId, element, setText } from "./dom";

/** The errors are compared over this time before the shown moment, s. It is longer than the adapter's memory, and shorter than a phase. */
const COMPARED_S = 5;
/** A reset this long ago is still told as what the adapter does now, s. */
const RECENT_RESET_S = 3;
const PERCENT = 100;
const DEGREES = 180 / Math.PI;

/** Root mean square of the errors of the base and of the adapted forecast, over all coordinates, in z-scores. */
export function errorsOf(store: Store): { base: number; adapted: number } {
  const last = store.shownTick;
  const first = Math.max(store.history.first, last - Math.round(COMPARED_S / store.tickS));
  let [count, base, adapted] = [0, 0, 0];
  for (const row of store.rows()) {
    const scale = store.channel(`residual.${row}`)?.z_scale ?? null;
    if (scale === null) continue;
    for (let tick = first; tick <= last; tick += 1) {
      const measured = store.at(`residual.${row}`, tick);
      const [a, b] = [(measured - store.at(`base.${row}`, tick)) / scale, (measured - store.at(`adapted.${row}`, tick)) / scale];
      if (Number.isNaN(a) || Number.isNaN(b)) continue;
      count += 1;
      base += a * a;
      adapted += b * b;
    }
  }
  return count === 0 ? { base: NaN, adapted: NaN } : { base: Math.sqrt(base / count), adapted: Math.sqrt(adapted / count) };
}

/** One sentence about the adapter at the shown moment. */
export function adapterSentence(store: Store): string {
  if (store.shown("frozen") > 0.5) return "The adapter is frozen: it learns nothing now.";
  const { base, adapted } = errorsOf(store);
  if (Number.isNaN(base)) return "No residual is known here, so nothing can be said about the adapter.";
  const share = base === 0 ? 0 : Math.round(PERCENT * (1 - adapted / base));
  const part = Math.round((PERCENT * store.shown("innovation_mean")) / store.shown("reset_threshold"));
  const does = share >= 0 ? `removes ${share} % of the base error` : `adds ${-share} % to the base error`;
  const reset = store.resets.filter((tick) => tick <= store.shownTick).at(-1);
  const ago = reset === undefined ? Infinity : (store.shownTick - reset) * store.tickS;
  const last = reset === undefined ? "no reset" : ago < RECENT_RESET_S ? `reset ${ago.toFixed(1)} s ago, learning` : `last reset ${store.timeOf(reset).toFixed(2)} s`;
  return `The adapter ${does}; innovation ${Number.isNaN(part) ? "unknown" : `${part} % of δ`}; ${last}.`;
}

export interface Margin {
  name: string;
  text: string;
  /** Whether the margin is used up. */
  used: boolean;
}

/** The margins at the shown moment; a number that nobody knows is left out. */
export function marginsOf(store: Store): Margin[] {
  const margins: Margin[] = [];
  const add = (name: string, value: number, text: string, used: boolean): void => void (Number.isFinite(value) && margins.push({ name, text, used }));
  const error = store.shown("position_error_m");
  add("off reference", error, `${(PERCENT * error).toFixed(1)} cm`, false);
  const rotors = (store.hello?.channels ?? []).filter(({ name, limits }) => name.startsWith("rotor.") && limits !== null);
  const load = Math.max(...rotors.map(({ name, limits }) => store.shown(name) / (limits?.[1] ?? NaN)));
  add("rotor thrust", load, `${Math.round(PERCENT * load)} % of the most`, store.shown("saturated") > 0.5);
  const tilt = Math.acos(Math.cos(store.shown("chi.phi")) * Math.cos(store.shown("chi.theta"))) * DEGREES;
  add("tilt", tilt, `${tilt.toFixed(1)}°`, false);
  const trusts = store.rows().map((row) => store.shown(`trust.${row}`)).filter((trust) => !Number.isNaN(trust));
  const trust = trusts.length === 0 ? NaN : Math.min(...trusts);
  add("least forecast trust", trust, `${Math.round(PERCENT * trust)} %`, trust === 0);
  const part = store.shown("innovation_mean") / store.shown("reset_threshold");
  add("innovation", part, `${Math.round(PERCENT * part)} % of δ`, part >= 1);
  return margins;
}

export class Story {
  private readonly sentence = byId("story");

  constructor(private readonly store: Store) {}

  /** Writes sentence and margins; called a few times a second. */
  readings(): void {
    if (this.store.history.length === 0) return;
    const text = adapterSentence(this.store);
    setText(this.sentence, text);
    this.sentence.title = `${text} Compared over the last ${COMPARED_S} s, over all coordinates in z-scores.`;
    const root = document.getElementById("margins");
    if (root === null) return;
    const margins = marginsOf(this.store);
    while (root.childElementCount > 2 * margins.length) root.lastElementChild?.remove();
    margins.forEach(({ name, text: value, used }, k) => {
      if (root.children[2 * k] === undefined) root.append(element("dt", {}), element("dd", {}));
      setText(root.children[2 * k] as HTMLElement, name);
      const cell = root.children[2 * k + 1] as HTMLElement;
      setText(cell, used ? `▲ ${value}` : value);
      cell.dataset["tone"] = used ? "warn" : "";
    });
  }
}
