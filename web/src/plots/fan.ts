// The forecast that was made at one tick, over its whole horizon: the fan. Its band widens from now to the lead.
import type { Store } from "../data/store";
import type { Sample } from "../data/decimate";

/** Steps of the forecast that have channels, ticks. */
const FAN_TICKS = [5, 10, 15, 20, 25];
/** Standard deviations that hold 90 % of the errors. */
export const BAND_90 = 1.645;

export interface FanPoint {
  /** Time that is forecast, s. */
  time: number;
  value: number;
  /** Half the width of the band; null if it is unknown. */
  half: number | null;
}

export interface Fan {
  /** Time at which the forecast was made, s. */
  time: number;
  /** Lead of the compensation, s; 0 without a lead. */
  leadS: number;
  /** The forecast from now to its horizon; now alone if it has none. */
  points: FanPoint[];
}

/** The forecast of coordinate `row` that was made at `tick`, with values multiplied by `scale`; null if there is none. */
export function fanOf(store: Store, row: string, tick: number, scale: number): Fan | null {
  const at = (stem: string): number => store.withoutWeight(`${stem}.${row}`, tick) * scale;
  const now = at("adapted");
  if (Number.isNaN(now)) return null;
  const lead = store.at(`lead_s.${row}`, tick);
  const leadS = lead > 0 ? lead : 0;
  const steps: [number, number][] = FAN_TICKS.map((ticks) => [ticks * store.tickS, at(`fan_${String(ticks).padStart(2, "0")}`)]);
  if (leadS > 0) steps.push([leadS, at("foreseen")]);
  const known = steps.filter(([, value]) => !Number.isNaN(value)).sort(([a], [b]) => a - b);
  const [stdNow, std] = [at("foresight_std_now"), at("foresight_std")];
  const half = (ahead: number): number | null => {
    const width = BAND_90 * (stdNow + (std - stdNow) * Math.min(1, ahead / leadS));
    return leadS === 0 || Number.isNaN(width) ? null : width;
  };
  const time = store.timeOf(tick);
  return { time, leadS, points: [[0, now] as const, ...known].map(([ahead, value]) => ({ time: time + ahead, value, half: half(ahead) })) };
}

/** Values from the lower to the upper edge of the band, for the range of an axis. */
export function extentOf(fan: Fan | null): Sample[] {
  return (fan?.points ?? []).flatMap(({ value, half }) => [value - (half ?? 0), value + (half ?? 0)]);
}
