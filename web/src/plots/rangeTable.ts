// The table with the minimum, mean, maximum and root mean square of every line shown, over the range between I and O.
import { statistics } from "../data/statistics";
import type { Store } from "../data/store";
import { byId, element } from "../panels/dom";
import { symbolOf } from "./spec";
import type { Panel } from "./panel";
import { formatValue } from "./range";
import type { Span, View } from "./view";

export interface RangeRow {
  channel: string;
  min: number;
  mean: number;
  max: number;
  rms: number;
}

export class RangeTable {
  rows: RangeRow[] = [];
  private readonly root = byId("range-table");
  private readonly title = element("h3");
  private readonly body = element("tbody");

  constructor(
    private readonly store: Store,
    view: View,
  ) {
    const close = element("button", { textContent: "✕", ariaLabel: "Close the statistics and forget the range", title: "Forget the range" });
    close.addEventListener("click", () => view.clearRange());
    const names = ["", "min", "mean", "max", "rms", "unit"].map((textContent) => element("th", { textContent, scope: "col" }));
    const table = element("table", {}, [element("thead", {}, [element("tr", {}, names)]), this.body]);
    this.root.replaceChildren(element("header", {}, [this.title, close]), element("div", { className: "range-rows", tabIndex: 0 }, [table]));
  }

  /** Shows the statistics over `range`; null hides the table. */
  show(range: Span | null, panels: Panel[]): void {
    this.root.hidden = range === null;
    if (range === null) {
      this.rows = [];
      return;
    }
    const [from, to] = [this.store.tickAt(range[0]), this.store.tickAt(range[1])];
    this.title.textContent = `${range[0].toFixed(2)} s to ${range[1].toFixed(2)} s (${(range[1] - range[0]).toFixed(2)} s)`;
    const names = [...new Set(panels.flatMap(({ spec }) => spec.series.map(({ channel }) => channel)))];
    const kept: RangeRow[] = [];
    this.body.replaceChildren(
      ...names.flatMap((name) => {
        const column = this.store.index(name);
        const channel = this.store.channel(name);
        if (column === undefined || channel === undefined) return [];
        const { min, mean, max, rms, missing, count } = statistics(this.store.history, column, from, to);
        kept.push({ channel: name, min, mean, max, rms });
        const label = channel.row === null ? channel.label : channel.label.replace(new RegExp(`\\b${channel.row}\\b`), symbolOf(channel.row));
        const unknown = missing > 0 ? `${missing} of ${missing + count} ticks unknown` : `${count} ticks`;
        return element("tr", { title: `${name}: ${unknown}` }, [
          element("th", { textContent: missing > 0 ? `${label} *` : label, scope: "row" }),
          ...[min, mean, max, rms].map((value) => element("td", { textContent: formatValue(value) })),
          element("td", { className: "muted", textContent: channel.unit }),
        ]);
      }),
    );
    this.rows = kept;
  }
}
