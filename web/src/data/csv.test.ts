import { describe, expect, it } from "vitest";
import { csvOf, shortest } from "./csv";
import { History } from "./history";

describe("csvOf", () => {
  it("writes every tick that came, NaN for an unknown value, and units in the head", () => {
    const history = new History(512, 2);
    history.push(3, [0.1, 5], 0);
    history.push(4, [NaN, 6], 0);
    history.push(7, [-2.5, 7], 0);
    const columns = [
      { column: 1, name: "a,b", unit: "" },
      { column: 0, name: "residual.z", unit: "N" },
    ];
    const text = csvOf(history, columns, 0, 99, (tick) => (tick + 1) * 0.01, (tick) => tick === 5 || tick === 6);
    expect(text).toBe('tick,t_s,"a,b",residual.z [N]\r\n3,0.04,5,0.1\r\n4,0.05,6,NaN\r\n7,0.08,7,-2.5\r\n');
  });
});

describe("shortest", () => {
  it("reads back as the same 32-bit float and adds no noise", () => {
    let state = 1;
    for (let i = 0; i < 2000; i += 1) {
      state = (state * 1103515245 + 12345) % 2147483648;
      const value = Math.fround((state / 2147483648 - 0.5) * 10 ** ((state % 13) - 6));
      expect(Math.fround(Number(shortest(value)))).toBe(value);
    }
    expect([Math.fround(0.1), 29.43, NaN].map((value) => shortest(Math.fround(value)))).toEqual(["0.1", "29.43", "NaN"]);
  });
});
