// The panels of the column. A panel is kept as long as it shows the same channels; new data never build a chart anew.
import type { Store } from "../data/store";
import { element } from "../panels/dom";
import type { Arrangement } from "./arrangement";
import { Chart } from "./chart";
import { CloseUp } from "./closeUp";
import type { ChartColors } from "./colors";
import { Multiples } from "./multiples";
import type { Panel } from "./panel";
import { type ChartSpec, chartSpecs, CLOSE_UP, MULTIPLES, ownSpec, SPECTRUM } from "./spec";
import { SpectrumBars } from "./spectrum";

export interface PanelActions {
  /** Called with each new panel. */
  made(panel: Panel): void;
  toggleZscore(): void;
  /** Chooses the coordinate of the charts. */
  choose(row: string): void;
}

export class Panels {
  list: Panel[] = [];
  /** Charts of this flight alone, which stand before the others. */
  extra: ChartSpec[] = [];
  private row = "";
  private signatures = new Map<Panel, string>();
  private readonly watcher = new IntersectionObserver((entries) => this.seen(entries));
  private zscoreButton: HTMLButtonElement | null = null;

  constructor(
    private readonly root: HTMLElement,
    private readonly store: Store,
    private readonly lineWidth: number,
    private readonly actions: PanelActions,
  ) {}

  /** All available charts: those of the console, then the operator's own. */
  specs(arrangement: Arrangement): ChartSpec[] {
    const { hello } = this.store;
    const channels = hello?.channels ?? [];
    const standard = chartSpecs(arrangement.row, channels, (hello?.mirror ?? null) !== null).filter(({ key }) => key !== SPECTRUM || this.hasSpectrum());
    return [...this.extra, ...standard, ...arrangement.own.map((own) => ownSpec(own, channels))];
  }

  /** Whether telemetry has a spectrum of more than one number. */
  hasSpectrum(): boolean {
    return (this.store.newest?.spectrum.length ?? 0) > 1;
  }

  /** Shows the charts of `arrangement`; with `anew` all panels are built anew. */
  sync(arrangement: Arrangement, colors: ChartColors, anew: boolean): void {
    this.row = arrangement.row;
    const specs = this.specs(arrangement).filter(({ key }) => !arrangement.hidden.includes(key));
    const old = anew ? [] : this.list;
    const next = specs.map((spec) => {
      const signature = JSON.stringify(spec);
      return old.find((panel) => this.signatures.get(panel) === signature) ?? this.make(spec, signature, colors);
    });
    for (const panel of this.list) {
      if (next.includes(panel)) continue;
      this.watcher.unobserve(panel.root);
      this.signatures.delete(panel);
      panel.destroy();
    }
    this.list = next;
    const roots = next.map(({ root }) => root);
    const same = roots.length === this.root.children.length && roots.every((root, index) => this.root.children[index] === root);
    if (!same) this.root.replaceChildren(...(roots.length > 0 ? roots : [element("p", { className: "muted empty", textContent: "No charts are chosen. The button Charts lists them." })]));
    if (this.zscoreButton !== null) this.zscoreButton.ariaPressed = String(arrangement.zscore);
  }

  private make(spec: ChartSpec, signature: string, colors: ChartColors): Panel {
    const panel = this.panelOf(spec, colors);
    this.signatures.set(panel, signature);
    this.watcher.observe(panel.root);
    this.actions.made(panel);
    return panel;
  }

  private panelOf(spec: ChartSpec, colors: ChartColors): Panel {
    if (spec.key === SPECTRUM) return new SpectrumBars(spec, this.store, colors);
    if (spec.key === MULTIPLES) return new Multiples(spec, this.store, colors, () => this.row, (row) => this.actions.choose(row));
    if (spec.key === CLOSE_UP) return new CloseUp(spec, spec.fan ?? "", this.store, colors, this.lineWidth);
    return new Chart(spec, this.store, colors, this.lineWidth, this.tools(spec));
  }

  /** The button that switches between physical units and z-scores, if the flight gives the scales of z-scores. */
  private tools(spec: ChartSpec): Node[] {
    const scored = spec.series.some(({ channel }) => (this.store.channel(channel)?.z_scale ?? null) !== null);
    if (spec.key !== "residual" || !scored) return [];
    const button = element("button", { className: "small", textContent: "z-score", title: "Divide by the scale with which the forecast was trained", ariaPressed: "false" });
    button.addEventListener("click", () => this.actions.toggleZscore());
    this.zscoreButton = button;
    return [button];
  }

  private seen(entries: IntersectionObserverEntry[]): void {
    for (const entry of entries) {
      const panel = this.list.find(({ root }) => root === entry.target);
      if (panel === undefined) continue;
      panel.visible = entry.isIntersecting;
      panel.round = -1;
    }
  }
}
