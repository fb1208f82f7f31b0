// Everything an operator works with beside the views: the tuning column, the panels of the top bar, the palette. What
// they do is registered as commands, so that each has its key, its line in the help and its place in the palette.
import type { Store } from "../data/store";
import { clockMs, type Link } from "../link/link";
import type { Hello } from "../protocol";
import { commands } from "./commands";
import { Compare } from "./compare";
import { byId, setText } from "./dom";
import { ForkPanel } from "./forkPanel";
import { FrameRate } from "./frameRate";
import { GainPanel, PRESETS } from "./gains";
import { SLOTS } from "./gainSets";
import { HistoryList } from "./historyList";
import { startLayout } from "./layout";
import { LinkPanel } from "./linkPanel";
import { LossNotice } from "./lossNotice";
import { notify } from "./notices";
import { overrideDialog } from "./override";
import { CommandPalette } from "./palette";
import type { Sources, Verb } from "./paletteItems";
import { magnitude, rangeOf, scaled } from "./ranges";
import { startRestart } from "./restart";
import { startTabs, type Tabs } from "./tabs";
import { Timing } from "./timing";
import type { TopBar } from "./topbar";
import { GRAMS_PER_KG, WorldPanel } from "./worldPanel";

export class Workbench {
  readonly gains: GainPanel;
  readonly forks: ForkPanel;
  readonly loss = new LossNotice((text) => notify("warning", text));
  private readonly world: WorldPanel;
  private readonly compare: Compare;
  private readonly history: HistoryList;
  private readonly deskTabs: Tabs;
  private readonly sectionTabs: Tabs;
  private readonly timing = new Timing();
  private readonly linkPanel = new LinkPanel();
  private readonly rate = new FrameRate();
  private readonly lock = byId<HTMLFieldSetElement>("desk-lock");
  private readonly saveOverride: () => Promise<void>;
  private focusBeforeLock: HTMLElement | null = null;

  constructor(
    private readonly store: Store,
    private readonly link: Link,
    private readonly bar: TopBar,
    moment: () => number | null,
  ) {
    this.gains = new GainPanel((request) => link.send(request), () => this.changed());
    this.world = new WorldPanel(store, (request) => link.send(request));
    this.forks = new ForkPanel(store, (request) => link.send(request), moment, () => this.gains.model.list());
    this.compare = new Compare(this.gains);
    this.history = new HistoryList(this.gains.desk);
    this.deskTabs = startTabs(byId("desk-tabs"), "twin.tab", (id) => {
      byId("gains-head").hidden = id === "tab-world" || id === "tab-forks";
      if (this.history !== undefined) this.changed();
    });
    startLayout((layout) => this.gains.setBrief(layout === "fly"));
    this.sectionTabs = startTabs(byId("sections"), "twin.section", (id) => (document.body.dataset["section"] = id));
    this.saveOverride = overrideDialog(() => store.hello?.scenario ?? "scenario");
    byId("override-open").addEventListener("click", () => void this.saveOverride());
    startRestart(() => store.state?.seed, (seed) => bar.restart(seed));
    for (const id of ["world-open", "wind-open"]) byId(id).addEventListener("click", () => this.showTab("tab-world"));
    const palette = new CommandPalette(() => this.sources());
    this.register(palette);
  }

  rebuild(hello: Hello): void {
    this.gains.rebuild(hello);
    this.world.rebuild();
    this.forks.rebuild();
    this.show();
  }

  /** Shows the newest `state`. */
  show(): void {
    this.world.show();
    const { state, hello } = this.store;
    if (state !== null) this.timing.show(state, hello?.tick_s ?? 0.01);
  }

  /** The 3-D view was drawn, ms. */
  drawn(nowMs: number): void {
    this.rate.frame(nowMs);
  }

  /** Called a few times a second. In the past the column shows what was in force then, and nothing can be changed. */
  readings(stale: boolean): void {
    const now = clockMs();
    const { playhead, events } = this.store;
    setText(byId("desk-locked"), playhead === null ? "Locked: what you see is old." : `As it was at ${this.store.timeOf(playhead).toFixed(2)} s. Go back to live to tune.`);
    // A fork of a past moment is asked for in the past.
    this.setLock(stale || (playhead !== null && this.deskTabs.shown !== "tab-forks"));
    this.gains.showAt(playhead, events);
    this.world.show();
    this.forks.readings();
    this.gains.desk.overdue();
    this.gains.noteLeads((row) => this.store.shown(`lead_s.${row}`));
    this.loss.due(now);
    const { state } = this.store;
    this.linkPanel.show({ health: this.link.health, now, flying: state?.phase === "flying", clients: state?.clients, pageFps: this.rate.at(performance.now()) });
  }

  showTab(id: string): void {
    this.sectionTabs.show("section-desk");
    this.deskTabs.show(id);
  }

  private get locked(): boolean {
    return this.lock.disabled;
  }

  /** Nothing can be tuned on values that are old; the keyboard is where it was when they are fresh again. */
  private setLock(stale: boolean): void {
    if (stale === this.lock.disabled) return;
    const { activeElement } = document;
    if (stale) this.focusBeforeLock = activeElement instanceof HTMLElement && this.lock.contains(activeElement) ? activeElement : null;
    this.lock.disabled = stale;
    byId("desk-locked").hidden = !stale;
    byId("last-change").hidden = stale;
    if (!stale && document.activeElement === document.body) this.focusBeforeLock?.focus();
  }

  private changed(): void {
    if (this.deskTabs === undefined) return;
    if (this.deskTabs.shown === "tab-compare") this.compare.show();
    if (this.deskTabs.shown === "tab-history") this.history.show();
  }

  private register(palette: CommandPalette): void {
    const tunable = (): boolean => !this.locked;
    const { gains, world, bar } = this;
    commands.register(
      { id: "page.palette", group: "Page", description: "find a command, a gain, a scenario", keys: ["Ctrl+K"], action: () => palette.open(), whileTyping: true, keyOnly: true },
      { id: "flight.seed", group: "Flight", description: "restart with a seed", keys: ["Shift+R"], action: () => byId("restart-panel").showPopover() },
      { id: "flight.slower", group: "Flight", description: "slower", keys: ["-"], action: () => bar.faster(-1) },
      { id: "flight.faster", group: "Flight", description: "faster", keys: ["+", "="], action: () => bar.faster(1) },
      { id: "flight.timing", group: "Flight", description: "show the stages of a tick", keys: [], action: () => byId("timing-panel").showPopover() },
      { id: "flight.link", group: "Flight", description: "show the health of the link", keys: ["L"], action: () => byId("link-panel").showPopover() },
      { id: "gains.undo", group: "Gains", description: "undo the last change", keys: ["Ctrl+Z"], action: () => gains.undo(), when: tunable },
      { id: "gains.redo", group: "Gains", description: "do it again", keys: ["Ctrl+Shift+Z"], action: () => gains.redo(), when: tunable },
      { id: "gains.show", group: "Gains", description: "go to the filter of the gains", keys: ["G"], action: () => this.goTo("tab-gains", "gain-filter") },
      { id: "gains.compare", group: "Gains", description: "compare with the preset or a set", keys: ["C"], action: () => this.goTo("tab-compare", "diff-against") },
      { id: "gains.history", group: "Gains", description: "list of changes", keys: ["Y"], action: () => this.goTo("tab-history", "tab-history") },
      { id: "gains.toggle", group: "Gains", description: "switch between set A and set B", keys: ["X"], action: () => this.compare.toggle(), when: tunable },
      ...SLOTS.map((slot, index) => ({ id: `gains.keep${slot}`, group: "Gains", description: `keep the gains in force as set ${slot}`, keys: [String(index + 1)], action: () => this.compare.keep(slot), when: tunable })),
      ...PRESETS.map((name) => ({ id: `gains.${name}`, group: "Gains", description: `preset ${name}`, keys: [], action: () => gains.desk.choosePreset(name), when: tunable })),
      { id: "gains.reset", group: "Gains", description: "every gain back to the preset", keys: [], action: () => gains.resetAll(), when: tunable },
      { id: "gains.override", group: "Gains", description: "save as an override for a scenario file", keys: ["Ctrl+S"], action: () => void this.saveOverride(), whileTyping: true },
      { id: "world.show", group: "World", description: "payload, wind and effects", keys: ["W"], action: () => this.goTo("tab-world", "payload-number") },
      { id: "world.drop", group: "World", description: "drop the payload", keys: [], action: () => world.dropPayload(), when: tunable },
      { id: "world.calm", group: "World", description: "no wind", keys: [], action: () => world.setWindSpeed(0), when: tunable },
      { id: "forks.show", group: "Flight", description: "fork the flight: what if", keys: ["K"], action: () => this.goTo("tab-forks", "fork-here") },
      { id: "page.theme", group: "Page", description: "dark or light", keys: [], action: () => byId("theme").click() },
    );
  }

  private goTo(tab: string, control: string): void {
    this.showTab(tab);
    byId(control).focus();
  }

  private sources(): Sources {
    const { hello } = this.store;
    return {
      commands: commands.list(),
      scenarios: hello?.scenarios ?? [],
      gains: this.gains.model.list(),
      choices: chartChoices(),
      locked: this.locked,
      setGain: (name, value) => this.gains.desk.apply([{ name, value }]),
      showGain: (name) => {
        this.showTab("tab-gains");
        this.gains.focus(name);
      },
      startScenario: (name) => this.link.send({ type: "restart", seed: null, scenario: name }),
      verbs: this.verbs(),
    };
  }

  private verbs(): Verb[] {
    const { hello } = this.store;
    const [clock, payload, wind] = [rangeOf(hello, "speed"), rangeOf(hello, "payload_mass"), rangeOf(hello, "wind")];
    if (clock === null || payload === null || wind === null) return [];
    const grams = scaled(payload, GRAMS_PER_KG);
    return [
      { word: "seed", unit: "", tunes: false, min: 0, max: Number.MAX_SAFE_INTEGER, describe: (seed) => `Restart with seed ${seed}`, run: (seed) => this.bar.restart(Math.round(seed)) },
      { ...clock, word: "speed", tunes: false, describe: (speed) => `Fly at ${speed}× real time`, run: (value) => this.link.send({ type: "speed", value }) },
      { ...grams, word: "payload", unit: "g", tunes: true, describe: (mass) => `Payload of ${mass} g`, run: (mass) => this.world.setPayload(mass) },
      { ...magnitude(wind), word: "wind", unit: wind.unit, tunes: true, describe: (speed) => `Wind of ${speed} m/s`, run: (speed) => this.world.setWindSpeed(speed) },
    ];
  }
}

/** Windows and rows of the charts, as the controls above them offer them. */
function chartChoices(): Sources["choices"] {
  const select = byId<HTMLSelectElement>("window");
  const windows = [...select.options].map(({ value, label }) => ({
    text: `Charts: window of ${label}`,
    run: () => {
      select.value = value;
      select.dispatchEvent(new Event("change"));
    },
  }));
  const rows = [...byId("rows").querySelectorAll("button")].map((button) => ({ text: `Charts: row ${button.value}`, run: () => button.click() }));
  return [...windows, ...rows];
}
