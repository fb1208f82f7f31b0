// The commands of the charts. The keys of the playhead stand with the timeline.
import { type Command, commands } from "../panels/commands";
import type { View } from "./view";

export interface KeyTarget {
  view: View;
  /** Time at the cursor, else at the playhead, s. */
  cursor(): number;
}

const GROUP = "Charts";

export function registerChartKeys({ view, cursor }: KeyTarget): void {
  commands.register(
    { id: "charts.mark", group: GROUP, description: "set or remove a mark at the cursor", keys: ["M"], action: () => view.toggleMarker(cursor(), reach(view)) },
    { id: "charts.from", group: GROUP, description: "begin the range of the statistics here", keys: ["I"], action: () => view.setRange("from", cursor()) },
    { id: "charts.to", group: GROUP, description: "end the range of the statistics here", keys: ["O"], action: () => view.setRange("to", cursor()) },
  );
}

/** Actions of the charts that only the palette offers. */
export interface ChartActions {
  toggleZscore(): void;
  /** Adds a chart of the operator's own. */
  add(): void;
  toDefault(): void;
  forgetRange(): void;
  saveCsv(): void;
  savePng(): void;
}

export function registerChartActions(charts: ChartActions): void {
  const offer = (id: string, description: string, action: () => void): Command => ({ id: `charts.${id}`, group: GROUP, description, keys: [], action });
  commands.register(
    offer("zscore", "show residuals as z-scores or in physical units", charts.toggleZscore),
    offer("new", "add a chart of chosen channels", charts.add),
    offer("no-range", "forget the range of the statistics", charts.forgetRange),
    offer("csv", "save the time span in view as CSV", charts.saveCsv),
    offer("png", "save a picture of the charts", charts.savePng),
    offer("default", "reset charts, marks and window to the default", charts.toDefault),
  );
}

/** Marks that are closer together than this count as one, s. */
function reach(view: View): number {
  const [from, to] = view.span();
  return (to - from) / 200;
}
