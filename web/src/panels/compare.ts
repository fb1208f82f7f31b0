// The compare tab: the gains beside the preset or a stored set, the sets A and B, and the text for a scenario file.
import { byId, element, setText } from "./dom";
import { diff, type DiffRow, presetOf } from "./gainDiff";
import type { GainPanel } from "./gains";
import { GainSets, type Slot, SLOTS } from "./gainSets";
import type { Setting } from "./gainModel";
import { notify } from "./notices";
import { formatGain } from "./scale";

export class Compare {
  private readonly sets = new GainSets(localStorage);
  private readonly against = byId<HTMLSelectElement>("diff-against");
  private readonly onlyChanged = byId<HTMLInputElement>("diff-changed");
  private readonly toggleButton = byId<HTMLButtonElement>("ab-toggle");

  constructor(private readonly gains: GainPanel) {
    this.against.addEventListener("change", () => this.show());
    this.onlyChanged.addEventListener("change", () => this.show());
    this.toggleButton.addEventListener("click", () => this.toggle());
    for (const slot of SLOTS) byId(`keep-${slot}`).addEventListener("click", () => this.keep(slot));
  }

  /** Stores the values in force. */
  keep(slot: Slot): void {
    this.sets.keep(slot, this.now());
    notify("info", `set ${slot} now has the gains in force`);
    this.show();
  }

  /** Switches from set A to B or from B to A; from any other gains to A. */
  toggle(): void {
    const slot = this.sets.next(this.gains.desk.expected());
    if (slot === null) {
      const stored = SLOTS.filter((name) => this.sets.get(name) !== null);
      return notify("info", stored.length === 0 ? "no set is stored yet: first store the gains in force as A or B" : `only set ${stored.join(" and ")} is stored, and it is in force`);
    }
    this.gains.desk.apply(this.sets.get(slot) ?? [], `set ${slot}`);
    this.show();
  }

  show(): void {
    const now = this.now();
    for (const option of this.against.options) {
      if (option.value !== "preset") option.disabled = this.sets.get(option.value as Slot) === null;
    }
    const inForce = SLOTS.filter((slot) => this.sets.inForce(slot, now));
    const next = this.sets.next(now);
    setText(this.toggleButton, next === null ? "A ⇄ B" : `To ${next}`);
    this.toggleButton.disabled = next === null;
    const stored = SLOTS.filter((slot) => this.sets.get(slot) !== null);
    setText(byId("ab-state"), stored.length === 0 ? "nothing stored" : inForce.length > 0 ? `${inForce.join(" = ")} in force` : `stored: ${stored.join(", ")}`);
    this.table(now);
  }

  private table(now: Setting[]): void {
    const list = this.gains.model.list();
    const reference = this.against.value === "preset" ? presetOf(list) : (this.sets.get(this.against.value as Slot) ?? now);
    const name = this.against.value === "preset" ? (this.gains.model.base ?? "preset") : `set ${this.against.value}`;
    const rows = diff(list, reference, this.onlyChanged.checked);
    setText(byId("diff-reference"), name);
    byId("diff-rows").replaceChildren(...rows.map((row) => this.row(row)));
    const none = byId("diff-none");
    none.hidden = rows.length > 0;
    setText(none, `Every gain has its value of ${name === "preset" ? "the preset" : name}.`);
  }

  private row({ name, label, unit, reference, now, delta, changed }: DiffRow): HTMLElement {
    const back = element("button", { className: "default", textContent: "↺", ariaLabel: `${label} back to ${formatGain(reference)}`, title: `Back to ${formatGain(reference)}`, disabled: !changed });
    back.addEventListener("click", () => this.gains.desk.apply([{ name, value: reference }]));
    const sign = delta > 0 ? "+" : "";
    const made = element("tr", { className: changed ? "changed" : "" }, [
      element("th", { scope: "row", textContent: label, title: unit }),
      element("td", { textContent: formatGain(reference) }),
      element("td", { textContent: formatGain(now) }),
      element("td", { textContent: changed ? `${sign}${formatGain(delta)}`.replace("-", "−") : "0" }),
      element("td", {}, [back]),
    ]);
    made.dataset["gain"] = name;
    return made;
  }

  private now(): Setting[] {
    return this.gains.model.snapshot().settings;
  }
}
