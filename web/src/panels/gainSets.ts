// Two stored sets of gains, A and B, kept across a reload of the page.
import { type Setting, same } from "./gainModel";

export const SLOTS = ["A", "B"] as const;
export type Slot = (typeof SLOTS)[number];
type Store = Pick<Storage, "getItem" | "setItem">;

const KEY = "twin.set.";

export class GainSets {
  constructor(private readonly storage: Store) {}

  keep(slot: Slot, settings: Setting[]): void {
    this.storage.setItem(KEY + slot, JSON.stringify(settings));
  }

  /** The set in a slot; null if there is none that can be read. */
  get(slot: Slot): Setting[] | null {
    try {
      const stored: unknown = JSON.parse(this.storage.getItem(KEY + slot) ?? "null");
      return Array.isArray(stored) && stored.every(isSetting) ? stored : null;
    } catch {
      return null;
    }
  }

  /** Whether `now` equals the set in every gain that the set contains. */
  inForce(slot: Slot, now: Setting[]): boolean {
    const set = this.get(slot);
    return set !== null && differences(set, now).length === 0;
  }

  /** The set to which the toggle switches: the stored set that is not in force, A first; null if there is none. */
  next(now: Setting[]): Slot | null {
    const stored = SLOTS.filter((slot) => this.get(slot) !== null);
    return stored.find((slot) => !this.inForce(slot, now)) ?? null;
  }
}

/** The settings that turn `now` into `wanted`. */
export function differences(wanted: Setting[], now: Setting[]): Setting[] {
  const values = new Map(now.map(({ name, value }) => [name, value]));
  return wanted.filter(({ name, value }) => {
    const current = values.get(name);
    return current !== undefined && !same(current, value);
  });
}

function isSetting(item: unknown): item is Setting {
  return typeof item === "object" && item !== null && "name" in item && "value" in item && typeof item.name === "string" && typeof item.value === "number";
}
