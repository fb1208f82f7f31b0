// The gains panel: groups of rows, presets, history.
import type { ClientMessage, GainEcho, GainList, Hello, PresetName } from "../protocol";
import { byId, element, setText } from "./dom";
import { GainModel, type Requests, type Snapshot } from "./gainModel";
import { GainRow } from "./gainRow";
import { formatGain } from "./scale";

const PRESETS: PresetName[] = ["literal", "paper", "tuned"];

export class GainPanel {
  readonly model = new GainModel();
  private rows = new Map<string, GainRow>();
  private beforePreset: Snapshot | null = null;
  private pointedAt = "";
  private readonly undoButton = byId<HTMLButtonElement>("undo");
  private readonly redoButton = byId<HTMLButtonElement>("redo");
  private readonly presetButtons: HTMLButtonElement[];

  constructor(private readonly send: (message: ClientMessage) => void) {
    this.presetButtons = PRESETS.map((name) => {
      const button = element("button", { textContent: name, value: name });
      button.addEventListener("click", () => this.choosePreset(name));
      return button;
    });
    byId("presets").append(...this.presetButtons);
    this.undoButton.addEventListener("click", () => this.undo());
    this.redoButton.addEventListener("click", () => this.redo());
  }

  /** Shows the gains of a new connection or flight. */
  rebuild(hello: Hello): void {
    const open = new Map([...document.querySelectorAll<HTMLDetailsElement>("#gains details")].map((group) => [group.dataset["group"] ?? "", group.open]));
    this.model.load(hello.gains, hello.preset);
    this.beforePreset = null;
    this.rows = new Map();
    const groups = [...new Set(hello.gains.map((gain) => gain.group))];
    byId("gains").replaceChildren(...groups.map((group) => this.group(group, open.get(group) ?? true)));
    this.refresh();
  }

  echo({ name, value, preset }: GainEcho): void {
    this.model.echo(name, value, preset);
    // A preset's echoes are one action, and its list follows them.
    if (this.beforePreset === null) this.rows.get(name)?.answered();
    this.refresh();
  }

  /** A preset is in force. */
  replace({ gains, preset }: GainList): void {
    this.model.load(gains, preset);
    if (this.beforePreset !== null) this.model.commitSince(this.beforePreset);
    this.beforePreset = null;
    this.refresh();
  }

  /** A request was refused: what is shown is the server's value again. */
  refused(): void {
    this.beforePreset = null;
    this.rows.forEach((row) => row.refused());
  }

  undo(): void {
    this.apply(this.model.undo());
  }

  redo(): void {
    this.apply(this.model.redo());
  }

  values(): Record<string, number> {
    return Object.fromEntries(this.model.list().map(({ name, value }) => [name, value]));
  }

  private apply({ settings, preset }: Requests): void {
    if (preset !== null) this.send({ type: "preset", name: preset });
    settings.forEach(({ name, value }) => this.send({ type: "set_gain", name, value }));
    this.refresh();
  }

  private choosePreset(name: PresetName): void {
    this.beforePreset ??= this.model.snapshot();
    this.send({ type: "preset", name });
  }

  private group(group: string, open: boolean): HTMLElement {
    const gains = this.model.list().filter((gain) => gain.group === group);
    const rows = gains.map((gain) => {
      const current = (): typeof gain => this.model.get(gain.name) ?? gain;
      const row = new GainRow(current, {
        send: (name, value) => this.send({ type: "set_gain", name, value }),
        commit: (name, from, to) => {
          this.model.commit([{ name, from, to }], performance.now());
          this.refresh();
        },
        point: (name) => this.point(name),
      });
      this.rows.set(gain.name, row);
      return row.root;
    });
    const details = element("details", { open }, [element("summary", { textContent: group }), ...rows]);
    details.dataset["group"] = group;
    return details;
  }

  private refresh(): void {
    this.rows.forEach((row, name) => {
      row.mark(this.model.modified(name));
      row.show();
    });
    const count = this.model.modifiedCount();
    setText(byId("modified"), count === 0 ? "as preset" : `${count} changed`);
    this.presetButtons.forEach((button) => (button.ariaPressed = String(button.value === this.model.preset)));
    this.undoButton.disabled = !this.model.canUndo;
    this.redoButton.disabled = !this.model.canRedo;
    if (this.pointedAt !== "") this.point(this.pointedAt);
  }

  private point(name: string): void {
    const gain = this.model.get(name);
    if (gain === undefined) return;
    this.pointedAt = name;
    const unit = gain.unit === "" ? "" : ` ${gain.unit}`;
    setText(byId("gain-help"), `${gain.label}: ${gain.help}. ${formatGain(gain.min)} to ${formatGain(gain.max)}${unit}, preset ${formatGain(gain.preset_value)}.`);
  }
}
