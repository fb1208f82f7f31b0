// The dialog in which an operator composes a chart: a search over all channels, and the list of the chosen ones.
import { byId, element, setText } from "../panels/dom";
import type { ChannelInfo } from "../protocol";
import type { OwnChart } from "./arrangement";
import { matching } from "./search";

export interface PickerActions {
  /** Called when the channels or the title of the chart have changed. */
  changed(own: OwnChart): void;
  remove(own: OwnChart): void;
}

export class ChannelPicker {
  private readonly dialog = byId<HTMLDialogElement>("picker");
  private readonly title = element("input", { type: "text", maxLength: 40, ariaLabel: "Title of the chart" });
  private readonly search = element("input", { type: "search", placeholder: "name, label, group or unit", autocomplete: "off" });
  private readonly list = element("ul", { id: "picker-list", role: "listbox", ariaMultiSelectable: "true", ariaLabel: "Channels" });
  private readonly chosen = element("ul", { className: "chips", ariaLabel: "Channels of the chart" });
  private readonly count = element("p", { className: "muted", role: "status" });
  private channels: ChannelInfo[] = [];
  private found: ChannelInfo[] = [];
  private own: OwnChart = { key: "", title: "", channels: [] };
  private active = 0;

  constructor(private readonly actions: PickerActions) {
    this.search.setAttribute("role", "combobox");
    this.search.setAttribute("aria-controls", this.list.id);
    this.search.ariaLabel = "Search channels";
    this.search.ariaExpanded = "true";
    const done = element("button", { textContent: "Done" });
    const remove = element("button", { textContent: "Remove this chart" });
    done.addEventListener("click", () => this.dialog.close());
    remove.addEventListener("click", () => {
      this.dialog.close();
      actions.remove(this.own);
    });
    // Keys that are typed in this dialog must not start commands of the console.
    this.dialog.addEventListener("keydown", (event) => event.stopPropagation());
    this.search.addEventListener("input", () => this.filter());
    this.search.addEventListener("keydown", (event) => this.key(event));
    this.title.addEventListener("input", () => {
      this.own.title = this.title.value.trim() === "" ? "Chart" : this.title.value.trim();
      actions.changed(this.own);
    });
    this.dialog.replaceChildren(
      element("header", {}, [this.title, done]),
      this.chosen,
      this.search,
      this.count,
      this.list,
      element("p", { className: "muted", textContent: "↑ ↓ choose, Enter adds or removes, Esc closes." }),
      remove,
    );
  }

  open(own: OwnChart, channels: ChannelInfo[]): void {
    this.own = own;
    this.channels = channels;
    this.title.value = own.title;
    this.search.value = "";
    this.filter();
    this.showChosen();
    this.dialog.showModal();
    this.search.focus();
  }

  private filter(): void {
    this.found = matching(this.channels, this.search.value);
    this.active = 0;
    setText(this.count, `${this.found.length} of ${this.channels.length} channels`);
    this.list.replaceChildren(...this.found.map((channel, index) => this.item(channel, index)));
    this.mark();
  }

  private item(channel: ChannelInfo, index: number): HTMLLIElement {
    const { name, label, unit, group } = channel;
    const item = element("li", { role: "option", id: `picker-${index}` }, [
      element("span", { className: "tick", ariaHidden: "true" }),
      element("b", { textContent: label }),
      element("code", { textContent: name }),
      element("span", { className: "muted", textContent: [group, unit].filter((text) => text !== "").join(", ") }),
    ]);
    item.addEventListener("click", () => {
      this.active = index;
      this.toggle(channel);
    });
    return item;
  }

  private key(event: KeyboardEvent): void {
    const by = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
    if (by !== 0) {
      this.active = Math.min(this.found.length - 1, Math.max(0, this.active + by));
      this.mark();
    } else if (event.key === "Enter") {
      const channel = this.found[this.active];
      if (channel !== undefined) this.toggle(channel);
    } else if (event.key === "Escape") {
      // By default Escape only clears a search field.
      this.dialog.close();
    } else return;
    event.preventDefault();
  }

  private toggle({ name }: ChannelInfo): void {
    const at = this.own.channels.indexOf(name);
    if (at >= 0) this.own.channels.splice(at, 1);
    else this.own.channels.push(name);
    this.mark();
    this.showChosen();
    this.actions.changed(this.own);
  }

  /** Marks the chosen channels and the line at which the arrow keys stand. */
  private mark(): void {
    [...this.list.children].forEach((item, index) => {
      item.ariaSelected = String(this.own.channels.includes(this.found[index]?.name ?? ""));
      item.classList.toggle("active", index === this.active);
    });
    const active = this.list.children[this.active];
    active?.scrollIntoView({ block: "nearest" });
    this.search.setAttribute("aria-activedescendant", active?.id ?? "");
  }

  private showChosen(): void {
    const chips = this.own.channels.map((name) => {
      const remove = element("button", { textContent: `${name} ✕`, ariaLabel: `Remove ${name}` });
      remove.addEventListener("click", () => {
        const channel = this.channels.find((candidate) => candidate.name === name) ?? { name, label: name, group: "", unit: "", row: null };
        this.toggle(channel as ChannelInfo);
      });
      return element("li", {}, [remove]);
    });
    this.chosen.replaceChildren(...(chips.length === 0 ? [element("li", { className: "muted", textContent: "No channels yet." })] : chips));
  }
}
