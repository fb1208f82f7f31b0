// The gains tab: presets, buttons of the history, the last change, a filter, and groups of gains.
import type { ClientMessage, EventInfo, GainEcho, GainInfo, GainList, Hello, PresetName } from "../protocol";
import { byId, element, setText } from "./dom";
import { GainDesk } from "./gainDesk";
import { GainLog } from "./gainLog";
import type { GainModel } from "./gainModel";
import { GainRow } from "./gainRow";
import { remembered } from "./remembered";
import { formatGain } from "./scale";
import { spelled } from "./spelled";

const MS_PER_S = 1000;

export const PRESETS: PresetName[] = ["literal", "paper", "tuned"];

export class GainPanel {
  readonly desk: GainDesk;
  private rows = new Map<string, GainRow>();
  private readonly log = new GainLog();
  /** The past moment that is shown, with the events that lead to it; null while the values in force are shown. */
  private past: { tick: number; events: EventInfo[] } | null = null;
  private pointedAt = "";
  private readonly undoButton = byId<HTMLButtonElement>("undo");
  private readonly redoButton = byId<HTMLButtonElement>("redo");
  private readonly resetButton = byId<HTMLButtonElement>("reset-all");
  private readonly filter = byId<HTMLInputElement>("gain-filter");
  private readonly collapsed = remembered<string[]>("twin.collapsed", []);
  private readonly starred = remembered<string[]>("twin.starred", []);
  /** Whether only gains that are changed or starred are listed, unless the operator searches. */
  private brief = false;
  private readonly presetButtons: HTMLButtonElement[];

  /** `changed` is called whenever a value or the history may have changed. */
  constructor(
    send: (message: ClientMessage) => void,
    private readonly changed: () => void,
  ) {
    this.desk = new GainDesk(send);
    this.presetButtons = PRESETS.map((name) => {
      const button = element("button", { textContent: name, value: name });
      button.addEventListener("click", () => this.desk.choosePreset(name));
      return button;
    });
    byId("presets").append(...this.presetButtons);
    this.undoButton.addEventListener("click", () => this.undo());
    this.redoButton.addEventListener("click", () => this.redo());
    this.resetButton.addEventListener("click", () => this.resetAll());
    this.filter.addEventListener("input", () => this.applyFilter());
    this.filter.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || this.filter.value === "") return;
      event.preventDefault();
      this.filter.value = "";
      this.applyFilter();
    });
  }

  get model(): GainModel {
    return this.desk.model;
  }

  /** Lists only gains that are changed or starred, or all. */
  setBrief(brief: boolean): void {
    this.brief = brief;
    this.applyFilter();
  }

  /** Shows the gains of a new connection or flight. */
  rebuild(hello: Hello): void {
    this.desk.rebuild(hello);
    this.log.start(hello.gains, hello.state.tick);
    this.past = null;
    this.rows = new Map();
    const groups = [...new Set(hello.gains.map((gain) => gain.group))];
    byId("gains").replaceChildren(...groups.map((group) => this.group(group)), element("p", { className: "none muted", hidden: true }));
    this.applyFilter();
    this.refresh();
  }

  echo(echo: GainEcho): void {
    const own = this.desk.echo(echo);
    this.log.note(echo.name, echo.value, echo.tick);
    const row = this.rows.get(echo.name);
    // The echoes of a preset are one action, which the list of gains after them completes.
    if (!this.desk.presetPending) row?.answered();
    if (!own) row?.changedElsewhere();
    this.refresh();
  }

  /** Takes the gains of a preset that took effect. */
  replace(list: GainList): void {
    this.desk.replace(list);
    list.gains.forEach(({ name, value }) => this.log.note(name, value, list.tick));
    this.refresh();
  }

  /** Shows the server's values again after a refused request. */
  refused(): void {
    this.desk.refused();
    this.rows.forEach((row) => row.refused());
    this.refresh();
  }

  undo(): void {
    this.desk.undo();
    this.refresh();
  }

  redo(): void {
    this.desk.redo();
    this.refresh();
  }

  /** Sets every gain back to the preset chosen last, as one step of the history. */
  resetAll(): void {
    this.desk.apply(this.model.list().map(({ name, preset_value }) => ({ name, value: preset_value })), "all back to the preset");
    this.refresh();
  }

  /** Scrolls to the slider of `name` and gives it the focus. */
  focus(name: string): void {
    this.filter.value = this.brief && !this.model.modified(name) ? name : "";
    this.applyFilter();
    const row = this.rows.get(name);
    const group = row?.root.closest("details");
    if (group !== null && group !== undefined) group.open = true;
    row?.focus();
  }

  values(): Record<string, number> {
    return Object.fromEntries(this.model.list().map(({ name, value }) => [name, value]));
  }

  /** Shows the values that were in force at a past `tick`, or for null those in force. */
  showAt(tick: number | null, events: EventInfo[]): void {
    if (tick === null ? this.past === null : this.past?.tick === tick) return;
    const before = this.past;
    this.past = tick === null ? null : { tick, events };
    // Most moments have the gains of the moment before them.
    if (before === null || tick === null) return this.refresh();
    this.rows.forEach((row) => row.show());
  }

  /** The gain `name` as it is shown: with its value in force, or with that of a past moment. */
  private seen(gain: GainInfo): GainInfo {
    const now = this.model.get(gain.name) ?? gain;
    return this.past === null ? now : { ...now, value: this.log.at(gain.name, this.past.tick, this.past.events) ?? NaN };
  }

  /** Shows the values. */
  refresh(): void {
    this.rows.forEach((row, name) => {
      row.mark(this.model.modified(name), this.model.tickOf(name));
      row.show();
    });
    if (this.brief) this.applyFilter();
    const count = this.model.modifiedCount();
    setText(byId("modified"), count === 0 ? "as preset" : `${count} changed`);
    byId("modified").title = `${count} of ${this.model.list().length} gains differ from preset ${this.model.base ?? "chosen last"}`;
    this.resetButton.disabled = count === 0;
    this.presetButtons.forEach((button) => (button.ariaPressed = String(button.value === this.model.preset)));
    this.undoButton.disabled = !this.model.canUndo;
    this.redoButton.disabled = !this.model.canRedo;
    this.showLast();
    if (this.pointedAt !== "") this.point(this.pointedAt);
    this.changed();
  }

  /** Shows beside each share of the loop's delay the lead that it amounts to; `leadS` gives the lead of a coordinate, s. */
  noteLeads(leadS: (row: string) => number): void {
    this.rows.forEach((row, name) => {
      const [stem, coordinate] = name.split(".");
      if (stem !== "lead" || coordinate === undefined) return;
      const seconds = leadS(coordinate);
      row.note(Number.isNaN(seconds) ? "" : `${Math.round(seconds * MS_PER_S)} ms`);
    });
  }

  private showLast(): void {
    const { last } = this.desk;
    const line = byId("last-change");
    const text = last === null ? "No change in this flight yet." : `${last.text} from tick ${last.tick}${last.own ? "" : ", by another client"}`;
    setText(line, text);
    line.title = text;
  }

  private group(group: string): HTMLElement {
    const rows = this.model.list().filter((gain) => gain.group === group).map((gain) => this.row(gain));
    const details = element("details", {}, [element("summary", { textContent: group }), ...rows]);
    details.dataset["group"] = group;
    details.addEventListener("toggle", () => {
      // The filter opens groups by itself; only groups that the operator opens are remembered.
      if (this.filter.value !== "" || this.brief) return;
      const others = this.collapsed.get().filter((name) => name !== group);
      this.collapsed.set(details.open ? others : [...others, group]);
    });
    return details;
  }

  private row(gain: GainInfo): HTMLElement {
    const row = new GainRow(() => this.seen(gain), {
      send: (name, value) => this.desk.request(name, value),
      commit: (name, from, to) => {
        const tick = this.model.tickOf(name);
        this.model.commit([{ name, from, to }], performance.now(), tick === undefined ? {} : { tick });
        this.refresh();
      },
      point: (name) => this.point(name),
      star: (name) => this.star(name),
    });
    row.showStar(this.starred.get().includes(gain.name));
    this.rows.set(gain.name, row);
    return row.root;
  }

  private applyFilter(): void {
    const wanted = this.filter.value.trim().toLowerCase();
    const few = this.brief && wanted === "";
    this.rows.forEach((row, name) => {
      const gain = this.model.get(name);
      if (few) row.root.hidden = !(this.model.modified(name) || this.starred.get().includes(name) || row.root.contains(document.activeElement));
      else row.root.hidden = !`${name} ${gain?.label ?? ""} ${spelled(gain?.label ?? "")} ${gain?.group ?? ""} ${gain?.help ?? ""}`.toLowerCase().includes(wanted);
    });
    let found = false;
    for (const details of document.querySelectorAll<HTMLDetailsElement>("#gains details")) {
      details.hidden = details.querySelector(".gain:not([hidden])") === null;
      details.open = wanted !== "" || few || !this.collapsed.get().includes(details.dataset["group"] ?? "");
      found ||= !details.hidden;
    }
    const none = document.querySelector<HTMLElement>("#gains .none");
    if (none === null) return;
    none.hidden = found;
    setText(none, few ? "Every gain has its value of the preset, and none is starred. Search above to change one; ☆ keeps it here. The layout tune lists all." : "No gain has this text in its name or help.");
  }

  private star(name: string): void {
    const others = this.starred.get().filter((other) => other !== name);
    const on = others.length === this.starred.get().length;
    this.starred.set(on ? [...others, name] : others);
    this.rows.get(name)?.showStar(on);
    this.applyFilter();
  }

  private point(name: string): void {
    const gain = this.model.get(name);
    if (gain === undefined) return;
    this.pointedAt = name;
    const unit = gain.unit === "" ? "" : ` ${gain.unit}`;
    const tick = this.model.tickOf(name);
    const since = tick === undefined ? "" : `, in force from tick ${tick}`;
    setText(byId("gain-help"), `${gain.label} (${name}): ${gain.help}. ${formatGain(gain.min)} to ${formatGain(gain.max)}${unit}, preset ${formatGain(gain.preset_value)}${since}.`);
  }
}
