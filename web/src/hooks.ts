// What a test may read of the page: values as shown, never a way to change them.
import type { Store } from "./data/store";
import type { Link } from "./link/link";
import type { GainPanel } from "./panels/gains";
import type { DrawnPose } from "./scene/bodies";
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
  /** Newest value of every channel; null where unknown. */
  readonly channels: Record<string, number | null>;
  /** Reset marks in the history of the charts. */
  readonly resets: number;
  readonly rows: number;
  readonly gapTicks: number;
}

declare global {
  interface Window {
    __twin?: TwinHooks;
  }
}

export function installHooks(store: Store, link: Link, gains: GainPanel, world: () => World | null): void {
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
      return world()?.drawn() ?? {};
    },
    get channels() {
      const names = (store.hello?.channels ?? []).map(({ name }) => name);
      return Object.fromEntries(names.map((name) => [name, finite(store.latest(name))]));
    },
    get resets() {
      return store.resets.length;
    },
    get rows() {
      return store.ring.length;
    },
    get gapTicks() {
      return link.health.gapTicks;
    },
  });
}

function finite(value: number): number | null {
  return Number.isFinite(value) ? value : null;
}
