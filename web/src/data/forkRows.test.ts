import { describe, expect, it } from "vitest";
import { HEADER_BYTES, MAGIC, VERSION } from "../link/decode";
import type { ForkInfo } from "../protocol";
import { ForkRows } from "./forkRows";

const WIDTH = 2;

/** A frame with `rows` rows from tick `first` on; column 0 is the tick, and column 1 is unknown. */
function frame(first: number, rows: number): ArrayBuffer {
  const bytes = new ArrayBuffer(HEADER_BYTES + 4 * (rows * WIDTH + 7));
  const head = new DataView(bytes);
  head.setUint8(0, MAGIC);
  head.setUint8(1, VERSION);
  head.setUint32(4, first, true);
  head.setUint16(8, rows, true);
  head.setUint16(10, WIDTH, true);
  const values = new Float32Array(bytes, HEADER_BYTES);
  for (let row = 0; row < rows; row += 1) values.set([first + row, NaN], row * WIDTH);
  return bytes;
}

function fork(id: number, ticks: number): ForkInfo {
  return { id, slot: 0, name: "", at_s: 1, set: [], changed: [], state: "flying", ticks, flown_s: 1, outcome: null, metrics: [] };
}

const settled = (): Promise<void> => new Promise((resolve) => setTimeout(resolve, 0));
const timeOf = (tick: number): number => (tick + 1) * 0.01;

describe("the rows of the forks", () => {
  it("come piece by piece, and each piece once", async () => {
    const asked: string[] = [];
    const rows = new ForkRows((address) => {
      asked.push(address);
      const from = Number(address.split("/").at(-1));
      return Promise.resolve(frame(100 + from, 3));
    });
    rows.update([fork(7, 3)]);
    await settled();
    rows.update([fork(7, 6)]);
    await settled();
    rows.update([fork(7, 6)]);
    await settled();
    expect(asked).toEqual(["/api/forks/7/0", "/api/forks/7/3"]);
    expect(rows.at(7, 0, 105)).toBe(105);
    expect(rows.at(7, 0, 106)).toBeNaN();
    expect(rows.at(7, 0, 99)).toBeNaN();
    expect(rows.end).toBe(106);
    expect(rows.line(7, 0, [101, 200], 2, timeOf)).toEqual([[timeOf(101), 101], [timeOf(103), 103], [timeOf(105), 105]]);
    expect(rows.line(7, 1, [101, 200], 1, timeOf)).toEqual([]);
  });

  it("are forgotten with their fork", async () => {
    const rows = new ForkRows(() => Promise.resolve(frame(0, 2)));
    rows.update([fork(1, 2)]);
    await settled();
    rows.update([]);
    expect(rows.at(1, 0, 0)).toBeNaN();
    expect(rows.end).toBe(-Infinity);
  });
});
