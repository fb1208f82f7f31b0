// Converts the wind between words (speed, and the bearing from which it comes) and the velocity of the air (x east, y north, z up).

export interface WindForm {
  /** Horizontal speed, m/s. */
  speed: number;
  /** Compass bearing from which the wind comes, degrees in [0, 360): 0 is north, 90 east. */
  from: number;
  /** Updraft, m/s. */
  up: number;
}

type Vector = [number, number, number];

const POINTS = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"];
const CALM = 1e-9;

/** Velocity of the air, m/s, rounded to a hundredth. */
export function windVector({ speed, from, up }: WindForm): Vector {
  const bearing = (from * Math.PI) / 180;
  const round = (value: number): number => Math.round(value * 100) / 100 + 0;
  return [round(-speed * Math.sin(bearing)), round(-speed * Math.cos(bearing)), round(up)];
}

/** The wind of a velocity of the air. A calm has no bearing of its own; `bearing` serves instead. */
export function windForm([x, y, z]: Vector, bearing: number): WindForm {
  const speed = Math.hypot(x, y);
  const from = speed < CALM ? bearing : (Math.atan2(-x, -y) * 180) / Math.PI;
  return { speed, from: ((Math.round(from) % 360) + 360) % 360, up: z };
}

/** Name of the nearest of eight points of the compass. */
export function compassPoint(bearing: number): string {
  return POINTS[Math.round((((bearing % 360) + 360) % 360) / 45) % 8] ?? "N";
}

/** A short phrase about the wind for the top bar. */
export function windText(vector: Vector): string {
  const { speed, from } = windForm(vector, 0);
  if (Math.hypot(...vector) < 0.05) return "calm";
  return speed < 0.05 ? `${Math.abs(vector[2]).toFixed(1)} m/s ${vector[2] > 0 ? "up" : "down"}` : `${speed.toFixed(1)} m/s from ${compassPoint(from)}`;
}
