// Gains as the server says they are, and the operator's way back. Nothing here changes a value by itself: a change is a
// request, and only the server's echo makes it true.
import type { GainInfo, PresetName } from "../protocol";

export interface Snapshot {
  settings: Setting[];
  preset: PresetName;
}

export interface Setting {
  name: string;
  value: number;
}

/** What an action asks of the server: single gains, or a preset where that is the same thing. */
export interface Requests {
  settings: Setting[];
  preset: PresetName | null;
}

interface Change {
  name: string;
  from: number;
  to: number;
}

interface Action {
  changes: Change[];
  /** Preset in force before and after; "custom" can only be reached gain by gain. */
  presets: { from: PresetName; to: PresetName } | null;
}

const NOTHING: Requests = { settings: [], preset: null };
const KEPT_CHANGES = 200;
/** Changes of one gain that follow each other faster than this are one action (an arrow key held down), ms. */
const ONE_ACTION_MS = 800;

export class GainModel {
  preset: PresetName = "custom";
  private readonly gains = new Map<string, GainInfo>();
  private committedAt = -Infinity;
  private undone: Action[] = [];
  private done: Action[] = [];

  load(gains: GainInfo[], preset: PresetName): void {
    this.preset = preset;
    this.gains.clear();
    gains.forEach((gain) => this.gains.set(gain.name, { ...gain }));
  }

  list(): GainInfo[] {
    return [...this.gains.values()];
  }

  get(name: string): GainInfo | undefined {
    return this.gains.get(name);
  }

  /** The server's word on one gain. */
  echo(name: string, value: number, preset: PresetName): void {
    this.preset = preset;
    const gain = this.gains.get(name);
    if (gain !== undefined) gain.value = value;
  }

  /** Differs from the preset by more than the rounding of a decimal number. */
  modified(name: string): boolean {
    const gain = this.gains.get(name);
    return gain !== undefined && !same(gain.value, gain.preset_value);
  }

  modifiedCount(): number {
    return this.list().filter((gain) => this.modified(gain.name)).length;
  }

  /** Remembers one operator action: a drag, a typed value, a whole preset. */
  commit(changes: Change[], nowMs = Infinity, presets: Action["presets"] = null): void {
    const real = changes.filter((change) => !same(change.from, change.to));
    const [only] = real;
    if (only === undefined) return;
    const last = this.done.at(-1);
    const following = nowMs - this.committedAt < ONE_ACTION_MS;
    this.committedAt = nowMs;
    if (following && real.length === 1 && last?.changes.length === 1 && last.changes[0]?.name === only.name) {
      last.changes[0].to = only.to;
      this.undone = [];
      return;
    }
    this.done = [...this.done, { changes: real, presets }].slice(-KEPT_CHANGES);
    this.undone = [];
  }

  get canUndo(): boolean {
    return this.done.length > 0;
  }

  get canRedo(): boolean {
    return this.undone.length > 0;
  }

  /** What takes the newest action back. */
  undo(): Requests {
    const action = this.done.pop();
    if (action === undefined) return NOTHING;
    this.undone.push(action);
    this.committedAt = -Infinity;
    return requests(action.changes.map(({ name, from }) => ({ name, value: from })), action.presets?.from);
  }

  /** What does again what was undone last. */
  redo(): Requests {
    const action = this.undone.pop();
    if (action === undefined) return NOTHING;
    this.done.push(action);
    return requests(action.changes.map(({ name, to }) => ({ name, value: to })), action.presets?.to);
  }

  /** Values now, to be handed to `commitSince` when a preset is in force. */
  snapshot(): Snapshot {
    return { settings: this.list().map(({ name, value }) => ({ name, value })), preset: this.preset };
  }

  /** Remembers everything that differs from `before` as one action. */
  commitSince(before: Snapshot): void {
    const changes = before.settings.map(({ name, value }) => ({ name, from: value, to: this.gains.get(name)?.value ?? value }));
    this.commit(changes, Infinity, { from: before.preset, to: this.preset });
  }
}

function requests(settings: Setting[], preset: PresetName | undefined): Requests {
  return preset === undefined || preset === "custom" ? { settings, preset: null } : { settings: [], preset };
}

function same(a: number, b: number): boolean {
  return Math.abs(a - b) <= 1e-9 * Math.max(1, Math.abs(a), Math.abs(b));
}
