// The part of the top bar that a mirrored recording has: what it is, and whether the twin holds. A simulated flight has none. The timeline
// at the foot plays and seeks the recording.
import type { Store } from "../data/store";
import type { MirrorInfo, TwinInfo } from "../protocol";
import { byId, element, setText } from "./dom";
import { hang } from "./popover";

export class MirrorBar {
  private readonly root = byId("mirror-bar");
  /** The result of the twin that is shown. */
  private shown: TwinInfo | null = null;

  constructor(private readonly store: Store) {
    hang(byId("mirror-panel"), byId("mirror-about"));
  }

  /** Takes a new `hello`. */
  rebuild(): void {
    const info = this.store.hello?.mirror ?? null;
    this.root.hidden = info === null;
    document.body.dataset["mode"] = info === null ? "fly" : "mirror";
    if (info === null) return;
    setText(byId("mirror-vehicle"), `${info.vehicle} · ${info.file}`);
    byId("mirror-vehicle").title = `${info.vehicle} · ${info.file}`;
    byId("mirror-facts").replaceChildren(...facts(info).flatMap(([name, text]) => [element("dt", { textContent: name }), element("dd", { textContent: text })]));
  }

  /** Shows how far the twin, which started from the state of the flight half a second ago, has departed from the flight. */
  readings(): void {
    const twin = this.store.state?.twin ?? null;
    if (this.root.hidden || twin === null || twin === this.shown) return;
    this.shown = twin;
    const badge = byId("mirror-twin");
    badge.dataset["light"] = twin.light ?? "unknown";
    badge.title = `${twin.says}; ${twin.horizon_s.toFixed(1)} s after it started from the state of the flight. The errors of each axis stand under About…`;
    setText(badge, verdict(twin));
    const gate = byId("mirror-gate");
    gate.dataset["light"] = twin.gate_passed === null ? "unknown" : twin.gate_passed ? "valid" : "doubtful";
    gate.title = `The forecast of the residual, since the last jump: ${twin.gate}`;
    setText(gate, gateText(twin));
    const head = ["axis", "twin", "twin with residual", "coasting"].map((textContent) => element("th", { textContent }));
    byId("mirror-axes").replaceChildren(row(head), ...cells(twin).map((texts) => row(texts.map((textContent) => element("td", { textContent })))));
  }
}

function row(children: HTMLElement[]): HTMLElement {
  const tr = element("tr", {});
  tr.append(...children);
  return tr;
}

const LIGHTS: Record<NonNullable<TwinInfo["light"]>, string> = { valid: "✓ twin holds", doubtful: "≈ twin doubtful", invalid: "✗ twin does not hold" };

/** The validity of the twin in words, so that it never depends on the colour alone. */
export function verdict(twin: TwinInfo): string {
  return twin.light === null ? "twin: unknown" : LIGHTS[twin.light];
}

/** The gate of the predictor in words: what it is not better than stands in the bar, the rest in the badge's title. */
export function gateText(twin: TwinInfo): string {
  if (twin.gate_passed === null) return "forecast: not scored";
  if (twin.gate_passed) return "✓ forecast better than persistence and mean";
  return `≈ forecast ${twin.gate.slice(Math.max(twin.gate.indexOf("not better"), 0))}`;
}

/** One line per axis with the errors of the twin, of the twin with residual and of coasting against the flight, mm or mrad. */
export function cells(twin: TwinInfo): string[][] {
  return twin.axes.map(({ row: name, twin: bare, with_residual, coasting }) => {
    const unit = ["x", "y", "z"].includes(name) ? "mm" : "mrad";
    return [name, ...[bare, with_residual, coasting].map((miss) => `${(1e3 * miss).toFixed(0)} ${unit}`)];
  });
}

/** Name and text of each line about the recording in the bar's panel. */
export function facts(info: MirrorInfo): [string, string][] {
  return [
    ["solid", `the real flight; ${info.stand_in}`],
    ["ghost", info.ghost],
    ["predictor", `${info.predictor}; it runs in shadow and moves nothing`],
    ["force", info.force],
    ["unknown", info.unknown_rows.length === 0 ? "nothing" : `residual of ${info.unknown_rows.join(", ")}: this recording does not contain it, so it is not shown`],
    ["map", info.map],
    ...info.notes.map((note): [string, string] => ["note", note]),
  ];
}
