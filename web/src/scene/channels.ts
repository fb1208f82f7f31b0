// Picks the numbers that the 3-D view shows out of a telemetry row. Their indices are found by name once per flight. Layout of the
// picked numbers: thrust of each rotor (N), estimate of the residual force (N, world), the adapter's share of it (N, world), wind
// (m/s, world).
import type { Telemetry } from "../link/decode";
import type { ChannelInfo } from "../protocol";

const AXES = ["x", "y", "z"];

export class SceneChannels {
  readonly count: number;
  /** Index of the first number of each triple among the picked numbers. */
  readonly estimateAt: number;
  readonly adapterAt: number;
  readonly windAt: number;
  private readonly rotors: number[];
  private readonly estimate: number[];
  private readonly adapted: number[];
  private readonly base: number[];
  private readonly wind: number[];

  constructor(channels: ChannelInfo[], rotors: number) {
    const columns = new Map(channels.map(({ name }, index) => [name, index]));
    const triple = (stem: string): number[] => AXES.map((axis) => columns.get(`${stem}.${axis}`) ?? -1);
    this.rotors = Array.from({ length: rotors }, (_, rotor) => columns.get(`rotor.${rotor}`) ?? -1);
    // The loop adds the low-passed and clipped r̂, not the adapted forecast from which it is computed.
    this.estimate = triple("r_hat");
    this.adapted = triple("adapted");
    this.base = triple("base");
    this.wind = triple("wind");
    this.estimateAt = rotors;
    this.adapterAt = rotors + 3;
    this.windAt = rotors + 6;
    this.count = rotors + 9;
  }

  /** Picks the numbers of the newest row of `frame` into `out` from `offset` on; NaN means unknown. */
  pick(frame: Telemetry, out: Float32Array, offset: number): void {
    const row = (frame.rows - 1) * frame.channelCount;
    const value = (column: number | undefined): number => (column === undefined || column < 0 || row < 0 ? NaN : (frame.channels[row + column] ?? NaN));
    this.rotors.forEach((column, i) => (out[offset + i] = value(column)));
    for (let axis = 0; axis < 3; axis += 1) {
      out[offset + this.estimateAt + axis] = value(this.estimate[axis]);
      out[offset + this.adapterAt + axis] = value(this.adapted[axis]) - value(this.base[axis]);
      out[offset + this.windAt + axis] = value(this.wind[axis]);
    }
  }
}
