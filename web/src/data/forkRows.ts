// The rows of the forks, which the page fetches piece by piece while they fly, and their lines on the charts.
import { decodeTelemetry } from "../link/decode";
import type { ForkInfo } from "../protocol";

/** Rows of one fork: `rows` of `width` values each, the first of which belongs to tick `first`. */
interface Rows {
  first: number;
  count: number;
  width: number;
  pieces: Float32Array[];
  asking: boolean;
}

/** A point of a line: time, s, and value. */
export type Point = [number, number];

export class ForkRows {
  private readonly rows = new Map<number, Rows>();
  /** Forks in the order of the server. */
  list: ForkInfo[] = [];
  /** Grows with every piece that came, so that the charts know when to draw. */
  version = 0;

  /** `get` fetches an address; a test gives another. */
  constructor(private readonly get: (address: string) => Promise<ArrayBuffer> = fetched) {}

  /** Takes the list of forks and asks for the rows that are missing. */
  update(list: ForkInfo[]): void {
    this.list = list;
    this.version += 1;
    const known = new Set(list.map(({ id }) => id));
    for (const id of this.rows.keys()) if (!known.has(id)) this.rows.delete(id);
    for (const fork of list) void this.ask(fork.id);
  }

  /** Tick after the last row of any fork; -Infinity without a row. */
  get end(): number {
    return Math.max(-Infinity, ...[...this.rows.values()].map(({ first, count }) => first + count));
  }

  /** Number of rows of a fork that the page has. */
  count(id: number): number {
    return this.rows.get(id)?.count ?? 0;
  }

  /** Value of a column of a fork at `tick`; NaN if the fork has no such row. */
  at(id: number, column: number, tick: number): number {
    const rows = this.rows.get(id);
    if (rows === undefined || column < 0 || column >= rows.width) return NaN;
    let place = tick - rows.first;
    for (const piece of rows.pieces) {
      const held = piece.length / rows.width;
      if (place < held) return place < 0 ? NaN : (piece[place * rows.width + column] ?? NaN);
      place -= held;
    }
    return NaN;
  }

  /** The line of a column between two ticks, a point every `step` ticks; unknown values are left out. */
  line(id: number, column: number, [from, to]: [number, number], step: number, timeOf: (tick: number) => number): Point[] {
    const rows = this.rows.get(id);
    if (rows === undefined) return [];
    const points: Point[] = [];
    const begin = Math.max(from, rows.first);
    for (let tick = begin; tick < Math.min(to, rows.first + rows.count); tick += step) {
      const value = this.at(id, column, tick);
      if (!Number.isNaN(value)) points.push([timeOf(tick), value]);
    }
    return points;
  }

  private async ask(id: number): Promise<void> {
    const rows = this.rows.get(id) ?? { first: NaN, count: 0, width: 0, pieces: [], asking: false };
    const wanted = (): number => this.list.find((fork) => fork.id === id)?.ticks ?? 0;
    if (rows.asking || wanted() <= rows.count) return;
    this.rows.set(id, rows);
    rows.asking = true;
    try {
      while (wanted() > rows.count) {
        const piece = decodeTelemetry(await this.get(`/api/forks/${id}/${rows.count}`));
        if (piece.rows === 0) return;
        if (rows.count === 0) [rows.first, rows.width] = [piece.firstTick, piece.channelCount];
        rows.pieces.push(piece.channels);
        rows.count += piece.rows;
        this.version += 1;
      }
    } catch {
      // A fork that was dropped meanwhile has no rows; the list of the server says so, too.
    } finally {
      rows.asking = false;
    }
  }
}

async function fetched(address: string): Promise<ArrayBuffer> {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${address}: ${answer.status}`);
  return answer.arrayBuffer();
}
