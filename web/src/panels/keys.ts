// Keys of the console. A key never acts while a text is being typed.
import { byId, element } from "./dom";

export interface KeyActions {
  pause(): void;
  step(): void;
  restart(): void;
  undo(): void;
  redo(): void;
  overview(): void;
  follow(): void;
  hand(): void;
}

const KEYS: [string[], string][] = [
  [["Space"], "pause or continue"],
  [["Ctrl", "→"], "one tick"],
  [["R"], "restart the flight"],
  [["Ctrl", "Z"], "undo the last gain change"],
  [["Ctrl", "Shift", "Z"], "do it again"],
  [["F"], "camera: the whole task"],
  [["V"], "camera: beside the vehicle"],
  [["H"], "close-up of the hand on or off"],
  [["?"], "this help"],
  [["↑", "↓"], "in a number field: one step, with Shift ten"],
];

export function startKeys(actions: KeyActions): void {
  const help = byId<HTMLDialogElement>("help");
  byId("help-keys").append(...KEYS.map(([keys, what]) => element("tr", {}, [element("td", {}, keyCaps(keys)), element("td", { textContent: what })])));
  byId("help-close").addEventListener("click", () => help.close());
  byId("help-open").addEventListener("click", () => help.showModal());
  document.addEventListener("keydown", (event) => {
    if (help.open || event.altKey || event.metaKey) return;
    const action = actionOf(event, actions, () => help.showModal());
    if (action === null) return;
    event.preventDefault();
    action();
  });
  // A control that was clicked gives the focus back, so that Space goes on meaning pause.
  document.addEventListener("click", (event) => {
    const target = event.target;
    if (event.detail > 0 && target instanceof Element) target.closest("button")?.blur();
  });
}

function actionOf(event: KeyboardEvent, actions: KeyActions, help: () => void): (() => void) | null {
  const target = event.target instanceof HTMLElement ? event.target : document.body;
  const typing = target instanceof HTMLInputElement && target.type === "number";
  if (event.ctrlKey) {
    if (event.code === "KeyZ" && !(typing && unsent(target))) return event.shiftKey ? actions.redo : actions.undo;
    return event.key === "ArrowRight" && !typing ? actions.step : null;
  }
  if (typing || target instanceof HTMLSelectElement) return null;
  if (event.key === "?") return help;
  if (event.repeat) return null;
  if (event.code === "Space") return usesSpace(target) ? null : actions.pause;
  if (event.code === "KeyR") return actions.restart;
  if (event.code === "KeyF") return actions.overview;
  if (event.code === "KeyV") return actions.follow;
  return event.code === "KeyH" ? actions.hand : null;
}

/** The field holds text the browser itself can undo. */
function unsent(field: HTMLInputElement): boolean {
  return field.matches(":focus") && field.dataset["typing"] === "true";
}

function usesSpace(target: HTMLElement): boolean {
  return target.matches("button, summary, input[type=checkbox]");
}

function keyCaps(keys: string[]): Node[] {
  return keys.flatMap((key, index) => [...(index > 0 ? [document.createTextNode(" ")] : []), element("kbd", { textContent: key })]);
}
