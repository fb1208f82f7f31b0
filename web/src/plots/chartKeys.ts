// The commands of the charts. During an inspection the arrow keys move the cursor of the charts and do not step the flight.
import { type Command, commands } from "../panels/commands";
import type { View } from "./view";

export interface KeyTarget {
  view: View;
  /** Period of a tick, s. */
  tickS(): number;
  oldest(): number;
  newest(): number;
  /** Tells the values at the cursor after a key has moved it. */
  moved(): void;
}

const STEP_S = 0.1;
const LONG_STEP_S = 1;
const GROUP = "Charts";

export function registerChartKeys(target: KeyTarget): void {
  const { view } = target;
  const cursor = (): number => view.cursor() ?? target.newest();
  const move = (id: string, key: string, description: string, to: () => number): Command => ({
    id: `charts.${id}`,
    group: GROUP,
    description: `while inspecting: ${description}`,
    keys: [key],
    action: () => {
      view.moveCursor(to());
      target.moved();
    },
    when: () => view.inspecting,
    repeats: true,
    keyOnly: true,
  });
  commands.register(
    { id: "charts.inspect", group: GROUP, description: "stop to inspect, or follow the flight again", keys: ["P"], action: () => (view.inspecting ? view.live() : view.hold()) },
    { id: "charts.mark", group: GROUP, description: "set or remove a mark at the cursor", keys: ["M"], action: () => view.toggleMarker(cursor(), reach(view)) },
    { id: "charts.from", group: GROUP, description: "begin the range of the statistics here", keys: ["I"], action: () => view.setRange("from", cursor()) },
    { id: "charts.to", group: GROUP, description: "end the range of the statistics here", keys: ["O"], action: () => view.setRange("to", cursor()) },
    { id: "charts.back", group: GROUP, description: "leave the zoom, then follow the flight again", keys: ["Escape"], action: () => void view.back(), when: () => view.inspecting && document.querySelector(":popover-open") === null },
    move("earlier", "ArrowLeft", "move the cursor back by 100 ms", () => cursor() - STEP_S),
    move("later", "ArrowRight", "move the cursor forward by 100 ms", () => cursor() + STEP_S),
    move("much-earlier", "Shift+ArrowLeft", "move the cursor back by 1 s", () => cursor() - LONG_STEP_S),
    move("much-later", "Shift+ArrowRight", "move the cursor forward by 1 s", () => cursor() + LONG_STEP_S),
    move("tick-earlier", "Ctrl+ArrowLeft", "move the cursor back by one tick", () => cursor() - target.tickS()),
    move("tick-later", "Ctrl+ArrowRight", "move the cursor forward by one tick", () => cursor() + target.tickS()),
    move("first", "Home", "move the cursor to the oldest tick", () => target.oldest()),
    move("last", "End", "move the cursor to the newest tick", () => target.newest()),
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
