// The world tab: payload, wind, effects. What is shown is what the server says is in force, within the ranges that it gives; a
// change is a request.
import type { Store } from "../data/store";
import type { WorldState } from "../data/stateLog";
import type { ClientMessage, Disturbance } from "../protocol";
import { byId, element, setText } from "./dom";
import { magnitude, type Range, rangeOf, scaled } from "./ranges";
import { compassPoint, windForm, type WindForm, windText, windVector } from "./wind";

export const GRAMS_PER_KG = 1000;
/** Speeds an operator asks for most, m/s. */
const WIND_PRESETS = [0, 3, 6];
/** A request without an answer for this long is given up, ms: the panel then shows the server's word again. */
const ANSWER_WITHIN_MS = 1500;

/** Force on the pads from which on the hand holds the payload, N; contacts that are solved leave less than a hundredth of it. */
const HELD_FROM_N = 0.1;
const NOT_HELD = "not held";

/** A slider and a number field that are one control. */
interface Pair {
  slider: HTMLInputElement;
  field: HTMLInputElement;
}

export class WorldPanel {
  private readonly payload = pair("payload");
  private readonly speed = pair("wind-speed");
  private readonly from = pair("wind-from");
  private readonly up = pair("wind-up");
  private heldUntil = 0;
  private bearing = 270;

  constructor(
    private readonly store: Store,
    private readonly send: (message: ClientMessage) => void,
  ) {
    listen(this.payload, () => this.hold(), (grams) => this.setPayload(grams));
    for (const wind of [this.speed, this.from, this.up]) listen(wind, () => this.hold(), () => this.setWind(this.formWind()));
    byId("payload-drop").addEventListener("click", () => this.dropPayload());
    byId("wind-presets").append(
      ...WIND_PRESETS.map((speed) => {
        const button = element("button", { textContent: speed === 0 ? "calm" : `${speed} m/s`, value: String(speed) });
        button.addEventListener("click", () => this.setWind({ speed, from: this.bearing, up: 0 }));
        return button;
      }),
    );
  }

  /** Another flight, other effects. */
  rebuild(): void {
    this.showRanges();
    const boxes = (this.store.hello?.effects ?? []).map((name) => {
      const box = element("input", { type: "checkbox", id: `effect-${name}` });
      box.addEventListener("change", () => this.disturb({ kind: "effect", name, on: box.checked }));
      return element("label", { className: "check" }, [box, name.replaceAll("_", " ")]);
    });
    byId("effects").replaceChildren(...boxes);
    this.heldUntil = 0;
    this.show();
  }

  private showRanges(): void {
    const { hello } = this.store;
    const payload = rangeOf(hello, "payload_mass");
    if (payload !== null) bound(this.payload, scaled(payload, GRAMS_PER_KG));
    const wind = rangeOf(hello, "wind");
    if (wind === null) return;
    bound(this.speed, magnitude(wind));
    bound(this.up, wind);
  }

  setPayload(grams: number): void {
    this.disturb({ kind: "payload_mass", kg: grams / GRAMS_PER_KG });
  }

  dropPayload(): void {
    this.disturb({ kind: "drop_payload" });
  }

  setWind(wind: WindForm): void {
    this.putWind(wind);
    this.disturb({ kind: "wind", velocity_m_s: windVector(wind) });
  }

  setWindSpeed(speed: number): void {
    this.setWind({ speed, from: this.bearing, up: 0 });
  }

  /** Shows the newest state, except in a control the operator has hold of. */
  show(): void {
    const { playhead } = this.store;
    const state = playhead === null ? this.store.state : this.store.states.at(playhead);
    if (state === null) return showUnknown();
    this.showReadings(state);
    if (performance.now() < this.heldUntil) return;
    const known = state.payload_kg !== null;
    if (state.payload_kg !== null) put(this.payload, Math.round(state.payload_kg * GRAMS_PER_KG * 10) / 10);
    [this.payload.slider, this.payload.field, byId<HTMLButtonElement>("payload-drop")].forEach((control) => (control.disabled = !known));
    const wind = windForm(state.wind_m_s, this.bearing);
    this.putWind(wind);
    for (const button of byId("wind-presets").querySelectorAll("button")) {
      button.ariaPressed = String(Math.abs(wind.speed - Number(button.value)) < 0.05 && Math.abs(wind.up) < 0.05);
    }
    for (const name of this.store.hello?.effects ?? []) byId<HTMLInputElement>(`effect-${name}`).checked = !state.effects_off.includes(name);
  }

  /** All three numbers at once: a change of one is sent with the others as they stand here. */
  private putWind(wind: WindForm): void {
    this.bearing = wind.from;
    put(this.speed, Math.round(wind.speed * 100) / 100);
    put(this.from, wind.from);
    put(this.up, wind.up);
    setText(byId("wind-point"), compassPoint(wind.from));
  }

  private showReadings(state: WorldState): void {
    const payload = state.payload_kg === null ? "none" : `${(state.payload_kg * GRAMS_PER_KG).toFixed(0)} g`;
    const held = heldText(this.store.shown("grip_force_n"));
    const [x, y, z] = state.wind_m_s.map((value) => value.toFixed(1).replace("-", "−"));
    setText(byId("payload-now"), state.payload_kg !== null && held === NOT_HELD ? NOT_HELD : payload);
    byId("world-open").title = `Payload of ${payload}${held === "" ? "" : `, ${held} by the hand`}: open the world tab (W)`;
    setText(byId("wind-now"), windText(state.wind_m_s));
    setText(byId("payload-force"), state.payload_kg === null ? "This flight has no payload." : `In force: ${payload}${held === "" ? "" : `, ${held} by the hand`}`);
    setText(byId("wind-force"), `In force: ${windText(state.wind_m_s)}, air moves (${x}, ${y}, ${z}) m/s east, north, up`);
  }

  private formWind(): WindForm {
    return { speed: this.speed.field.valueAsNumber, from: this.from.field.valueAsNumber, up: this.up.field.valueAsNumber };
  }

  private hold(): void {
    this.heldUntil = performance.now() + ANSWER_WITHIN_MS;
    setText(byId("wind-point"), compassPoint(this.from.slider.valueAsNumber));
  }

  private disturb(disturbance: Disturbance): void {
    this.hold();
    this.send({ type: "disturb", disturbance });
  }
}

/** Whether the hand holds the payload, from the force on its pads; empty if nobody knows. */
export function heldText(gripN: number): string {
  if (Number.isNaN(gripN)) return "";
  return gripN > HELD_FROM_N ? "held" : NOT_HELD;
}

/** The page does not know what was in force: it was opened later. */
function showUnknown(): void {
  for (const id of ["payload-now", "wind-now"]) setText(byId(id), "–");
  for (const id of ["payload-force", "wind-force"]) setText(byId(id), "Unknown at this moment: this page was opened later.");
}

function pair(id: string): Pair {
  return { slider: byId<HTMLInputElement>(id), field: byId<HTMLInputElement>(`${id}-number`) };
}

/** The slider stands on multiples of its step, from the first that is allowed; the field takes any number of the range. */
function bound({ slider, field }: Pair, { min, max, step }: Range): void {
  slider.min = String(Math.ceil(min / step) * step);
  slider.step = String(step);
  field.min = String(min);
  slider.max = field.max = String(max);
}

function put({ slider, field }: Pair, value: number): void {
  slider.value = String(value);
  if (document.activeElement !== field || field.dataset["typing"] !== "true") field.value = String(value);
}

/** A slider asks when it is let go, a field when it is left or entered: every request is an event of the flight. */
function listen({ slider, field }: Pair, touched: () => void, ask: (value: number) => void): void {
  slider.addEventListener("input", () => {
    field.value = slider.value;
    touched();
  });
  slider.addEventListener("change", () => ask(slider.valueAsNumber));
  field.addEventListener("input", () => {
    field.dataset["typing"] = "true";
    touched();
  });
  field.addEventListener("change", () => {
    field.dataset["typing"] = "false";
    if (Number.isFinite(field.valueAsNumber)) ask(field.valueAsNumber);
  });
}
