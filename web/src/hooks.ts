// What a test may read of the page: values as shown, never a way to change them.
import type { Store } from "./data/store";
import type { Delivery, Link } from "./link/link";
import { commands } from "./panels/commands";
import type { GainPanel } from "./panels/gains";
import type { ChartColumn } from "./plots/column";
import type { DrawnPose } from "./scene/bodies";
import { inspect, type SceneHooks } from "./scene/inspect";
import type { World } from "./scene/world";

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
  /** The 3-D view as drawn; null where there is none. */
  readonly scene: SceneHooks | null;
  /** Newest value of every channel; null where unknown. */
  readonly channels: Record<string, number | null>;
  /** Reset marks in the history of the charts. */
  readonly resets: number;
  readonly rows: number;
  readonly gapTicks: number;
  readonly delivery: Delivery | null;
  /** What can be done, and the keys for it. */
  readonly commands: { id: string; keys: string[] }[];
  /** What the charts show: the stretch in s, the cursor, and of each chart its lines as drawn. */
  readonly charts: ChartHooks;
  /** Value of a channel at a tick as the history holds it; null if it is unknown or not held. */
  at(channel: string, tick: number): number | null;
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

export function installHooks(store: Store, link: Link, gains: GainPanel, charts: ChartColumn, world: () => World | null): void {
  window.__twin = Object.freeze({
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
      return Object.fromEntries(names.map((name) => [name, finite(store.latest(name))]));
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
