// The command palette (Ctrl+K): a text field, a list of items, and the keys that choose one.
import { capsOf } from "./chord";
import { byId, element } from "./dom";
import { keyCaps } from "./keys";
import { type Item, itemsFor, type Sources } from "./paletteItems";

export class CommandPalette {
  private readonly dialog = byId<HTMLDialogElement>("palette");
  private readonly input = byId<HTMLInputElement>("palette-input");
  private readonly list = byId<HTMLUListElement>("palette-list");
  private items: Item[] = [];
  private chosen = 0;

  constructor(private readonly sources: () => Sources) {
    byId("palette-open").addEventListener("click", () => this.open());
    this.input.addEventListener("input", () => this.search());
    this.input.addEventListener("keydown", (event) => this.key(event));
    this.dialog.addEventListener("click", (event) => {
      if (event.target === this.dialog) this.dialog.close();
    });
  }

  open(): void {
    this.input.value = "";
    this.search();
    this.dialog.showModal();
    this.input.focus();
  }

  private search(): void {
    this.items = itemsFor(this.input.value, this.sources());
    const options = this.items.map((item, index) => this.option(item, index));
    this.list.replaceChildren(...(options.length > 0 ? options : [element("li", { className: "none muted", textContent: "Nothing fits." })]));
    this.choose(0);
  }

  private option({ text, hint, usable }: Item, index: number): HTMLElement {
    const isKey = /^\S{1,20}$/.test(hint) && !/^[\d.]+$/.test(hint) && text.includes(":");
    const option = element("li", { id: `palette-${index}`, role: "option", ariaDisabled: String(!usable) }, [
      element("span", { textContent: text }),
      element("span", { className: "hint" }, isKey ? keyCaps(capsOf(hint)) : [hint]),
    ]);
    option.addEventListener("click", () => this.run(index));
    return option;
  }

  private key(event: KeyboardEvent): void {
    const by = { ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8 }[event.key];
    if (by !== undefined) {
      event.preventDefault();
      const wrapped = Math.abs(by) === 1 ? (this.chosen + by + this.items.length) % Math.max(1, this.items.length) : this.chosen + by;
      this.choose(Math.min(this.items.length - 1, Math.max(0, wrapped)));
    } else if (event.key === "Enter") {
      event.preventDefault();
      // An item that was locked when the list was made may be usable now, so the search runs again.
      const { chosen } = this;
      this.search();
      this.choose(Math.min(chosen, Math.max(0, this.items.length - 1)));
      this.run(this.chosen);
    }
  }

  private choose(index: number): void {
    this.chosen = index;
    [...this.list.children].forEach((option, i) => (option.ariaSelected = String(i === index)));
    this.list.children[index]?.scrollIntoView({ block: "nearest" });
    this.input.setAttribute("aria-activedescendant", this.items.length === 0 ? "" : `palette-${index}`);
  }

  private run(index: number): void {
    const item = this.items[index];
    if (item === undefined || !item.usable) return;
    this.dialog.close();
    item.run();
  }
}
