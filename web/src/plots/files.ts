// Saves the content of the charts as files.
import { csvOf } from "../data/csv";
import type { Store } from "../data/store";
import { notify } from "../panels/notices";
import { clockText } from "./clock";
import type { ChartColors } from "./colors";
import type { Frame } from "./frame";
import type { Panel } from "./panel";
import { compose, download, fileStem } from "./picture";
import type { Span } from "./view";

/** Saves every tick in `span` of every channel shown, in physical units. */
export function saveCsv(store: Store, span: Span, panels: Panel[]): void {
  const names = [...new Set(panels.flatMap(({ spec }) => spec.series.map(({ channel }) => channel)))];
  const columns = names.flatMap((name) => {
    const column = store.index(name);
    return column === undefined ? [] : [{ column, name, unit: store.channel(name)?.unit ?? "" }];
  });
  const text = csvOf(store.history, columns, store.tickAt(span[0]), store.tickAt(span[1]), store.timeOf, (tick) => store.lost(tick));
  download(`${fileStem(scenarioOf(store), span)}.csv`, new Blob([text], { type: "text/csv" }));
}

export function savePng(store: Store, frame: Frame, panels: Panel[], timeline: HTMLCanvasElement, colors: ChartColors): void {
  const title = `${scenarioOf(store)}, seed ${store.state?.seed ?? "unknown"}, ${frame.span.map(clockText).join(" to ")}`;
  const sheet = compose(title, panels.map((panel) => panel.picture()), timeline, colors);
  sheet.toBlob((blob) => {
    if (blob === null) notify("error", `the browser could not make a picture of ${sheet.width} x ${sheet.height} pixels`);
    else download(`${fileStem(scenarioOf(store), frame.span)}.png`, blob);
  }, "image/png");
}

function scenarioOf(store: Store): string {
  return store.state?.scenario ?? store.hello?.scenario ?? "flight";
}
