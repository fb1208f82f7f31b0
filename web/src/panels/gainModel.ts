// Gains as the server says they are, and the operator's way back. Nothing here changes a value by itself: a change is a
// request, and only the server's echo makes it true.
import type { GainInfo } from "../protocol";

export interface Setting {
  name: string;
  value: number;
}

interface Change {
  name: string;
  from: number;
  to: number;
}

const KEPT_CHANGES = 200;
/** Changes of one gain that follow each other faster than this are one action (an arrow key held down), ms. */
const ONE_ACTION_MS = 800;

export class GainModel {
  preset = "";
  private readonly gains = new Map<string, GainInfo>();
  private committedAt = -Infinity;
  private undone: Change[][] = [];
  private done: Change[][] = [];

  load(gains: GainInfo[], preset: string): void {
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
  echo(name: string, value: number, preset: string): void {
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
  commit(changes: Change[], nowMs = Infinity): void {
    const real = changes.filter((change) => !same(change.from, change.to));
    const [only] = real;
    if (only === undefined) return;
    const last = this.done.at(-1);
    const following = nowMs - this.committedAt < ONE_ACTION_MS;
    this.committedAt = nowMs;
    if (following && real.length === 1 && last?.length === 1 && last[0]?.name === only.name) {
      last[0].to = only.to;
      this.undone = [];
      return;
    }
    this.done = [...this.done, real].slice(-KEPT_CHANGES);
    this.undone = [];
  }

  get canUndo(): boolean {
    return this.done.length > 0;
  }

  get canRedo(): boolean {
    return this.undone.length > 0;
  }

  /** Settings that take the newest action back; empty when there is none. */
  undo(): Setting[] {
    const action = this.done.pop();
    if (action === undefined) return [];
    this.undone.push(action);
    this.committedAt = -Infinity;
    return action.map(({ name, from }) => ({ name, value: from }));
  }

  /** Settings that do again what was undone last; empty when there is none. */
  redo(): Setting[] {
    const action = this.undone.pop();
    if (action === undefined) return [];
    this.done.push(action);
    return action.map(({ name, to }) => ({ name, value: to }));
  }

  /** Values now, to be handed to `commitSince` when a preset is in force. */
  snapshot(): Setting[] {
    return this.list().map(({ name, value }) => ({ name, value }));
  }

  /** Remembers everything that differs from `before` as one action. */
  commitSince(before: Setting[]): void {
    this.commit(before.map(({ name, value }) => ({ name, from: value, to: this.gains.get(name)?.value ?? value })));
  }
}

function same(a: number, b: number): boolean {
  return Math.abs(a - b) <= 1e-9 * Math.max(1, Math.abs(a), Math.abs(b));
}
