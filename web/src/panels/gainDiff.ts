// Compares the gains with a reference: the preset, or a stored set.
import type { GainInfo } from "../protocol";
import { type Setting, same } from "./gainModel";

export interface DiffRow {
  name: string;
  label: string;
  unit: string;
  reference: number;
  now: number;
  /** Value in force minus reference. */
  delta: number;
  changed: boolean;
}

/** One line per gain that the reference contains, in the order of `gains`. */
export function diff(gains: GainInfo[], reference: Setting[], onlyChanged: boolean): DiffRow[] {
  const known = new Map(reference.map(({ name, value }) => [name, value]));
  const rows = gains.flatMap(({ name, label, unit, value }) => {
    const before = known.get(name);
    if (before === undefined) return [];
    const changed = !same(value, before);
    return [{ name, label, unit, reference: before, now: value, delta: changed ? value - before : 0, changed }];
  });
  return onlyChanged ? rows.filter(({ changed }) => changed) : rows;
}

/** The preset chosen last, as a reference. */
export function presetOf(gains: GainInfo[]): Setting[] {
  return gains.map(({ name, preset_value }) => ({ name, value: preset_value }));
}
