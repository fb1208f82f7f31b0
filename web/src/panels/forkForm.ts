// What the form of a fork asks for, as the keys of a scenario.
export interface ForkForm {
  /** Gains by name. */
  gains: { name: string; value: number }[];
  /** Word of a predictor; empty leaves it. */
  predictor: string;
  /** Whether the adapter is in force; null leaves it. */
  adapter: boolean | null;
  /** Mass of the payload, g; NaN leaves it. */
  payloadG: number;
  /** Wind east, north and up, m/s; NaN leaves it. */
  wind: [number, number, number];
}

/** Coordinates of the gains that a scenario holds as lists, in their order. */
const ROWS = ["x", "y", "z", "phi", "theta", "psi", "q1", "q2"];

/** The form as keys of a scenario, `key=value` each. */
export function keysOf({ gains, predictor, adapter, payloadG, wind }: ForkForm): string[] {
  const keys = gains.map(({ name, value }) => `gains.${gainKey(name)}=${float(value)}`);
  if (predictor !== "") keys.push(`predictor.kind=${predictor}`);
  if (adapter !== null) keys.push(`gains.adapter_on=${adapter ? "1.0" : "0.0"}`);
  if (Number.isFinite(payloadG)) keys.push(`payload.mass_kg=${float(payloadG / 1000)}`);
  if (wind.some(Number.isFinite)) keys.push(`wind.velocity_m_s=[${wind.map((speed) => float(Number.isFinite(speed) ? speed : 0)).join(",")}]`);
  return keys;
}

/** The key of a gain: `slope.x` is element 0 of a list. */
function gainKey(name: string): string {
  const [stem = "", row] = name.split(".");
  return row === undefined ? stem : `${stem}.${ROWS.indexOf(row)}`;
}

/** A number as TOML writes a float; rounded to nine digits, so that 0.35 stays 0.35. */
function float(value: number): string {
  const text = String(Number(value.toPrecision(9)));
  return /[.e]/.test(text) ? text : `${text}.0`;
}

/** The command that repeats a fork of a flight that nobody operated. */
export function commandOf(scenario: string, seed: number, atS: number, set: string[]): string {
  const quoted = set.map((key) => `--set '${key.replaceAll("'", "'\\''")}'`);
  return ["twin fly", `scenarios/${scenario}.toml`, "--headless", "--seed", String(seed), "--fork-at", String(Number(atS.toFixed(2))), ...quoted].join(" ");
}
