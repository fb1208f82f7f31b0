// The items that the palette offers for a text: all that fit, and the command that the text itself spells ("damping.z 12").
import type { GainInfo, ScenarioInfo } from "../protocol";
import type { Command } from "./commands";
import { rank } from "./fuzzy";
import { formatGain } from "./scale";
import { spelled } from "./spelled";

export interface Item {
  text: string;
  /** Text beside the item: its key, or the reason why it cannot be chosen. */
  hint: string;
  /** Further words by which the item is found. */
  words: string;
  usable: boolean;
  run(): void;
}

export interface Sources {
  commands: Command[];
  scenarios: ScenarioInfo[];
  gains: GainInfo[];
  setGain(name: string, value: number): void;
  showGain(name: string): void;
  startScenario(name: string): void;
  /** Further choices by name, such as the window of the charts. */
  choices: { text: string; run(): void }[];
  /** Whether the data are stale, so that gains and the world cannot be set. */
  locked: boolean;
  /** Commands that take a number: "seed 7". */
  verbs: Verb[];
}

export interface Verb {
  word: string;
  unit: string;
  min: number;
  max: number;
  /** Whether the verb sets something that is locked while the data are stale. */
  tunes: boolean;
  describe(value: number): string;
  run(value: number): void;
}

const SHOWN_AT_MOST = 40;

/** Items for `query`, best first. */
export function itemsFor(query: string, sources: Sources): Item[] {
  const said = spoken(query, sources);
  if (said.length > 0) return said;
  return rank(query, all(sources), ({ text, words }) => `${text} ${words}`).slice(0, SHOWN_AT_MOST);
}

/** Items for a name and a number: a gain by its name or symbol, or a verb. */
function spoken(query: string, sources: Sources): Item[] {
  const parts = /^(.+?)\s*[\s=]\s*([-−]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)$/i.exec(query.trim());
  const [, name, digits] = parts ?? [];
  if (name === undefined || digits === undefined) return [];
  const value = Number(digits.replace("−", "-"));
  const verbs = sources.verbs.filter(({ word }) => word === name.toLowerCase());
  const exact = sources.gains.filter((gain) => [gain.name, gain.label.toLowerCase(), spelled(gain.label)].includes(name.toLowerCase()));
  const gains = exact.length > 0 || verbs.length > 0 ? exact : rank(name, sources.gains, (gain) => `${gain.name} ${spelled(gain.label)}`).slice(0, 8);
  return [
    ...verbs.map((verb) => ranged(verb.describe(value), value, verb, sources.locked && verb.tunes, () => verb.run(value))),
    ...gains.map((gain) => ranged(`Set ${gain.label} (${gain.name}) to ${formatGain(value)}`, value, gain, sources.locked, () => sources.setGain(gain.name, value), `now ${formatGain(gain.value)}`)),
  ];
}

function ranged(text: string, value: number, { min, max, unit }: { min: number; max: number; unit: string }, locked: boolean, run: () => void, more = ""): Item {
  const allowed = value >= min && value <= max;
  const range = `${formatGain(min)} to ${formatGain(max)} ${unit}`.trim();
  const hint = allowed ? more : `allowed: ${range}`;
  return { text, hint: locked ? "locked: what you see is old" : hint, words: "", usable: allowed && !locked, run };
}

function all({ commands, scenarios, gains, showGain, startScenario, choices, verbs }: Sources): Item[] {
  return [
    ...commands
      .filter(({ keyOnly, when }) => keyOnly !== true && (when?.() ?? true))
      .map(({ group, description, keys, action, id }) => ({ text: `${group}: ${description}`, hint: keys.join("  "), words: id, usable: true, run: action })),
    ...choices.map(({ text, run }) => ({ text, hint: "", words: "", usable: true, run })),
    ...scenarios.map(({ name, title }) => ({ text: `Fly scenario ${name}`, hint: "", words: title, usable: true, run: () => startScenario(name) })),
    ...verbs.map(({ word, unit, min, max }) => ({ text: `${word} …`, hint: `type: ${word} and a number, ${formatGain(min)} to ${formatGain(max)} ${unit}`.trim(), words: "", usable: false, run: () => {} })),
    ...gains.map((gain) => ({
      text: `Gain ${gain.label} (${gain.name})`,
      hint: `${formatGain(gain.value)} ${gain.unit}`.trim(),
      words: `${spelled(gain.label)} ${gain.group}`,
      usable: true,
      run: () => showGain(gain.name),
    })),
  ];
}
