// The history tab lists every change that this page made, newest first. Choosing a change restores the gains after it.
import { byId, element } from "./dom";
import type { GainDesk } from "./gainDesk";

export class HistoryList {
  private readonly list = byId<HTMLOListElement>("history");
  private shown = "";

  constructor(private readonly desk: GainDesk) {}

  show(): void {
    const entries = this.desk.model.history();
    const text = JSON.stringify(entries);
    if (text === this.shown) return;
    this.shown = text;
    const done = entries.filter(({ undone }) => !undone).length;
    const start = this.item("as it was before", null, 0, done);
    const items = entries.map((entry, index) => this.item(entry.text, entry.tick, index + 1, done));
    this.list.replaceChildren(...items.reverse(), start);
  }

  private item(text: string, tick: number | null, count: number, done: number): HTMLElement {
    const button = element("button", { ariaPressed: null }, [element("span", { textContent: text }), element("span", { className: "tick", textContent: tick === null ? "" : `@${tick}` })]);
    const here = count === done;
    button.title = here ? "The gains now in force" : count > done ? "Undone; choose it to redo the changes up to here" : "Go back to the gains after this change";
    if (here) button.ariaCurrent = "step";
    button.classList.toggle("undone", count > done);
    button.addEventListener("click", () => {
      this.desk.goTo(count);
      this.show();
    });
    return element("li", {}, [button]);
  }
}
