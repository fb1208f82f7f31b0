// The gains in force at the server, and the operator's undo history. The model never changes a value by itself: a change is a
// request, and only the server's echo changes the value.
import type { GainInfo, PresetName } from "../protocol";
import { formatGain } from "./scale";

export interface Snapshot {
  settings: Setting[];
  preset: PresetName;
}

export interface Setting {
  name: string;
  value: number;
}

/** Requests to the server for one action: single gains, or a preset if it has the same effect. */
export interface Requests {
  settings: Setting[];
  preset: PresetName | null;
}

export interface Change {
  name: string;
  from: number;
  to: number;
}

/** Facts about an action other than its values. */
export interface About {
  /** Preset in force before and after. "custom" is no preset: its gains are requested one by one. */
  presets?: { from: PresetName; to: PresetName };
  /** Title in the list of the history, if the changes alone do not explain the action. */
  title?: string;
  /** First tick flown with the new values. */
  tick?: number;
}

interface Action extends About {
  changes: Change[];
}

/** One line of the history. */
export interface Entry {
  text: string;
  tick: number | null;
  undone: boolean;
}

const NOTHING: Requests = { settings: [], preset: null };
const KEPT_CHANGES = 200;
/** Changes of one gain that follow each other faster than this are one action (an arrow key held down), ms. */
const ONE_ACTION_MS = 800;

export class GainModel {
  preset: PresetName = "custom";
  /** Preset chosen last, to which the preset values belong; null if it was chosen before this page connected. */
  base: PresetName | null = null;
  private readonly gains = new Map<string, GainInfo>();
  private readonly ticks = new Map<string, number>();
  private committedAt = -Infinity;
  private undone: Action[] = [];
  private done: Action[] = [];

  load(gains: GainInfo[], preset: PresetName): void {
    this.preset = preset;
    if (preset !== "custom") this.base = preset;
    this.gains.clear();
    gains.forEach((gain) => this.gains.set(gain.name, { ...gain }));
  }

  /** Forgets the tick numbers of the last flight, which mean nothing in a new one. */
  forgetTicks(): void {
    this.ticks.clear();
    [...this.done, ...this.undone].forEach((action) => delete action.tick);
  }

  list(): GainInfo[] {
    return [...this.gains.values()];
  }

  get(name: string): GainInfo | undefined {
    return this.gains.get(name);
  }

  /** First tick flown with the value in force; unknown until the gain is changed in this flight. */
  tickOf(name: string): number | undefined {
    return this.ticks.get(name);
  }

  /** Takes the server's echo of one gain. */
  echo(name: string, value: number, preset: PresetName, tick?: number): void {
    this.preset = preset;
    const gain = this.gains.get(name);
    if (gain === undefined) return;
    gain.value = value;
    if (tick !== undefined) this.ticks.set(name, tick);
  }

  /** Whether the gain differs from the preset by more than the rounding of a decimal number. */
  modified(name: string): boolean {
    const gain = this.gains.get(name);
    return gain !== undefined && !same(gain.value, gain.preset_value);
  }

  modifiedCount(): number {
    return this.list().filter((gain) => this.modified(gain.name)).length;
  }

  /** Remembers one operator action: a drag, a typed value, a whole preset. */
  commit(changes: Change[], nowMs = Infinity, about: About = {}): void {
    const real = changes.filter((change) => !same(change.from, change.to));
    const [only] = real;
    if (only === undefined) return;
    const last = this.done.at(-1);
    const following = nowMs - this.committedAt < ONE_ACTION_MS;
    this.committedAt = nowMs;
    this.undone = [];
    if (following && real.length === 1 && last?.changes.length === 1 && last.changes[0]?.name === only.name) {
      last.changes[0].to = only.to;
      Object.assign(last, about);
      return;
    }
    this.done = [...this.done, { changes: real, ...about }].slice(-KEPT_CHANGES);
  }

  get canUndo(): boolean {
    return this.done.length > 0;
  }

  get canRedo(): boolean {
    return this.undone.length > 0;
  }

  /** Requests that undo the newest action. */
  undo(): Requests {
    const action = this.done.pop();
    if (action === undefined) return NOTHING;
    this.undone.push(action);
    this.committedAt = -Infinity;
    return requests(action.changes.map(({ name, from }) => ({ name, value: from })), action.presets?.from);
  }

  /** Requests that redo the action that was undone last. */
  redo(): Requests {
    const action = this.undone.pop();
    if (action === undefined) return NOTHING;
    this.done.push(action);
    return requests(action.changes.map(({ name, to }) => ({ name, value: to })), action.presets?.to);
  }

  /** All actions of the history, oldest first; undone actions are at the end. */
  history(): Entry[] {
    const entry = (action: Action, undone: boolean): Entry => ({ text: this.describe(action), tick: action.tick ?? null, undone });
    return [...this.done.map((action) => entry(action, false)), ...this.undone.map((action) => entry(action, true)).reverse()];
  }

  /** Requests that lead to the state after the first `count` actions of the history, in the order in which to send them. */
  goTo(count: number): Requests[] {
    const asked: Requests[] = [];
    while (this.done.length > count && this.canUndo) asked.push(this.undo());
    while (this.done.length < count && this.canRedo) asked.push(this.redo());
    return asked;
  }

  /** The values in force; the caller passes them to `commitSince` when a preset has taken effect. */
  snapshot(): Snapshot {
    return { settings: this.list().map(({ name, value }) => ({ name, value })), preset: this.preset };
  }

  /** Remembers everything that differs from `before` as one action. */
  commitSince(before: Snapshot, about: About = { presets: { from: before.preset, to: this.preset } }): void {
    this.commitBetween(before.settings, this.snapshot().settings, about);
  }

  /** Remembers everything that differs between two states as one action. */
  commitBetween(before: Setting[], after: Setting[], about: About): void {
    const to = new Map(after.map(({ name, value }) => [name, value]));
    this.commit(before.map(({ name, value }) => ({ name, from: value, to: to.get(name) ?? value })), Infinity, about);
  }

  private describe({ changes, presets, title }: Action): string {
    const [only] = changes;
    if (title !== undefined) return title;
    if (presets !== undefined && presets.to !== "custom") return `preset ${presets.to}`;
    if (only === undefined || changes.length > 1) return `${changes.length} gains`;
    return `${this.gains.get(only.name)?.label ?? only.name} ${formatGain(only.from)} → ${formatGain(only.to)}`;
  }
}

function requests(settings: Setting[], preset: PresetName | undefined): Requests {
  return preset === undefined || preset === "custom" ? { settings, preset: null } : { settings: [], preset };
}

/** Whether two values are equal apart from the rounding of a decimal number. */
export function same(a: number, b: number): boolean {
  return Math.abs(a - b) <= 1e-9 * Math.max(1, Math.abs(a), Math.abs(b));
}
