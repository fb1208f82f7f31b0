// The values of the page that a browser test may read. They are the values shown, and a test cannot change them.
import type { Store } from "./data/store";
import type { Delivery, Link } from "./link/link";
import { commands } from "./panels/commands";
import type { GainPanel } from "./panels/gains";
import type { ChartColumn } from "./plots/column";
import type { DrawnPose } from "./scene/bodies";
import { inspect, type SceneHooks } from "./scene/inspect";
import type { World } from "./scene/world";
import type { TimeBar } from "./transport/bar";
import type { Transport } from "./transport/transport";

export interface TwinHooks {
  readonly state: unknown;
  readonly connected: boolean;
  readonly stale: boolean;
  readonly scenario: string;
  readonly lastTick: number;
  readonly gains: Record<string, number>;
  readonly preset: string;
  /** World poses as drawn, by body name. */
  readonly bodies: Record<string, DrawnPose>;
  /** The 3-D view as drawn; null if the browser cannot draw one. */
  readonly scene: SceneHooks | null;
  /** Newest value of every channel; null where unknown. */
  readonly channels: Record<string, number | null>;
  /** Number of reset marks in the history of the charts. */
  readonly resets: number;
  readonly rows: number;
  /** The forks and how many of their rows the page has. */
  readonly forks: { id: number; rows: number }[];
  readonly gapTicks: number;
  readonly delivery: Delivery | null;
  /** All commands and their keys. */
  readonly commands: { id: string; keys: string[] }[];
  /** The content of the charts: the stretch shown in s, the cursor, and the lines of each chart as drawn. */
  readonly charts: ChartHooks;
  /** The playhead, and the content of the timeline. */
  readonly time: TimeHooks;
  /** Value of a channel at a tick of the history; null if it is unknown, or if the tick is not in the history. */
  at(channel: string, tick: number): number | null;
}

export interface TimeHooks {
  readonly shown_s: number;
  readonly past: boolean;
  readonly playing: boolean;
  readonly lanes: TimeBar["shown"];
  /** Tick at the playhead. */
  readonly tick: number;
}

export interface ChartHooks {
  readonly inspecting: boolean;
  readonly zoomed: boolean;
  readonly span: readonly [number, number];
  readonly cursor: number | null;
  readonly cursorTick: number | null;
  readonly zscore: boolean;
  readonly gaps: readonly { from: number; to: number }[];
  readonly marks: readonly { kind: string; tick: number; text: string }[];
  readonly frozen: readonly (readonly [number, number])[];
  readonly panels: ReturnType<ChartColumn["shown"]>;
  readonly range: readonly { channel: string; min: number; mean: number; max: number; rms: number }[];
}

declare global {
  interface Window {
    __twin?: TwinHooks;
  }
}

export function installHooks(store: Store, link: Link, gains: GainPanel, charts: ChartColumn, world: () => World | null, time: () => { transport: Transport; bar: TimeBar }): void {
  window.__twin = Object.freeze({
    get forks() {
      return store.forks.list.map(({ id }) => ({ id, rows: store.forks.count(id) }));
    },
    get state() {
      return store.state === null ? null : { ...store.state };
    },
    get connected() {
      return link.health.connected;
    },
    get stale() {
      return document.body.dataset["stale"] === "true";
    },
    get scenario() {
      return store.hello?.scenario ?? "";
    },
    get lastTick() {
      return store.lastTick;
    },
    get gains() {
      return gains.values();
    },
    get preset() {
      return gains.model.preset;
    },
    get bodies() {
      return world()?.bodies?.drawn() ?? {};
    },
    get scene() {
      const shown = world();
      return shown === null ? null : inspect(shown);
    },
    get channels() {
      const names = (store.hello?.channels ?? []).map(({ name }) => name);
      return Object.fromEntries(names.map((name) => [name, finite(store.at(name, store.history.last))]));
    },
    get resets() {
      return store.resets.length;
    },
    get rows() {
      return store.history.length;
    },
    get gapTicks() {
      return link.health.gapTicks;
    },
    get delivery() {
      return link.delivery;
    },
    get charts() {
      return chartHooks(store, charts);
    },
    get time() {
      const { transport, bar } = time();
      return { shown_s: transport.timeS, past: transport.past, playing: transport.playing, lanes: bar.shown, tick: store.shownTick };
    },
    at: (channel: string, tick: number) => finite(store.at(channel, tick)),
    get commands() {
      return commands.list().map(({ id, keys }) => ({ id, keys: [...keys] }));
    },
  });
}

function chartHooks(store: Store, { view, drawn, arrangement, table, shown }: ChartColumn): ChartHooks {
  const span = drawn?.span ?? view.span();
  const cursor = view.cursor(span);
  return {
    inspecting: view.inspecting,
    zoomed: view.zoomed,
    span,
    cursor,
    cursorTick: cursor === null ? null : store.tickAt(cursor),
    zscore: arrangement.zscore,
    gaps: store.gaps,
    marks: drawn?.marks ?? [],
    frozen: drawn?.frozen ?? [],
    panels: shown(),
    range: table.rows,
  };
}

function finite(value: number): number | null {
  return Number.isFinite(value) ? value : null;
}
