// The keyboard and the help, which both read the list of commands. A key starts no command while the operator types a text, or
// while the control with the focus uses the key itself.
import { capsOf, chordOf } from "./chord";
import type { Command, Commands } from "./commands";
import { byId, element } from "./dom";

const OWN_ARROWS = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End", "PageUp", "PageDown"];

/** The first headings of the help; the others follow in the order of registration. */
const FIRST = ["Flight", "Gains", "World", "Charts"];

/** Keys of controls, for the help; the controls themselves listen to them. */
const CONTROL_KEYS: [string[], string][] = [
  [["↑", "↓"], "in a number field: one step, with Shift ten"],
  [["←", "→"], "on a slider: one step"],
  [["Esc"], "close what is open; in a number field: back to the value in force"],
];

export function startKeys(commands: Commands): void {
  const help = byId<HTMLDialogElement>("help");
  const openHelp = (): void => {
    byId("help-keys").replaceChildren(...helpRows(commands));
    help.showModal();
  };
  commands.register({ id: "page.help", group: "Page", description: "show all keys", keys: ["?"], action: openHelp });
  byId("help-close").addEventListener("click", () => help.close());
  byId("help-open").addEventListener("click", openHelp);
  document.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || document.querySelector("dialog[open]") !== null) return;
    const chord = chordOf(event);
    const command = commands.find(chord);
    if (command === undefined || takenByFocus(event.target, chord, command)) return;
    event.preventDefault();
    if (event.repeat && command.repeats !== true) return;
    command.action();
  });
  // A clicked control loses the focus again, so that Space still means pause.
  document.addEventListener("click", (event) => {
    const target = event.target;
    if (event.detail > 0 && target instanceof Element) target.closest("button")?.blur();
  });
}

/** Whether the control with the focus needs this key itself. */
function takenByFocus(target: EventTarget | null, chord: string, command: Command): boolean {
  if (!(target instanceof HTMLElement)) return false;
  const key = chord.split("+").at(-1) ?? chord;
  if (isTextField(target)) {
    if (!chord.startsWith("Ctrl+") || OWN_ARROWS.includes(key)) return true;
    return key === "Z" ? holdsUnsentText(target) : command.whileTyping !== true;
  }
  if (chord.startsWith("Ctrl+")) return false;
  if (target instanceof HTMLSelectElement) return true;
  if (chord === "Space") return target.matches("button, summary, a, input[type=checkbox], [role=option], [role=tab]");
  return OWN_ARROWS.includes(key) && target.matches("input[type=range], [role=radio], [role=tab], [role=log], [role=option]");
}

function isTextField(target: HTMLElement): boolean {
  return target.isContentEditable || target.matches("textarea, input:not([type=range], [type=checkbox], [type=radio], [type=button])");
}

/** Whether the browser itself can undo the typing in a field: in a text field always, in a number field until it is sent. */
function holdsUnsentText(field: HTMLElement): boolean {
  return !field.matches("input[type=number]") || field.dataset["typing"] === "true";
}

function helpRows(commands: Commands): Node[] {
  const place = (group: string): number => (FIRST.indexOf(group) + FIRST.length + 1) % (FIRST.length + 1);
  const groups = [...commands.groups()].sort(([a], [b]) => place(a) - place(b));
  const rows = groups.flatMap(([group, all]) => {
    const keyed = all.filter(({ keys }) => keys.length > 0);
    if (keyed.length === 0) return [];
    return [heading(group), ...keyed.map(({ id, keys, description }) => row(keys.map(capsOf), description, id))];
  });
  return [...rows, heading("Controls"), ...CONTROL_KEYS.map(([caps, what]) => row([caps], what, ""))];
}

function heading(group: string): HTMLElement {
  return element("tr", {}, [element("th", { colSpan: 2, scope: "colgroup", textContent: group })]);
}

function row(chords: string[][], what: string, id: string): HTMLElement {
  const caps = chords.flatMap((chord, index) => [...(index === 0 ? [] : [" or "]), ...keyCaps(chord)]);
  const made = element("tr", {}, [element("td", {}, caps), element("td", { textContent: what })]);
  made.dataset["command"] = id;
  return made;
}

export function keyCaps(caps: string[]): (Node | string)[] {
  return caps.flatMap((cap, index) => [...(index === 0 ? [] : [" "]), element("kbd", { textContent: cap })]);
}
