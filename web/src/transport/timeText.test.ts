import { describe, expect, it } from "vitest";
import { behindText, parseTime, timeText } from "./timeText";

describe("times", () => {
  it("are written with two decimals, and with minutes from the first on", () => {
    expect(timeText(7)).toBe("7.00");
    expect(timeText(59.99)).toBe("59.99");
    expect(timeText(62.5)).toBe("1:02.50");
    expect(behindText(17.72)).toBe("−17.7 s");
  });

  it("are read as seconds, as minutes and seconds, and as seconds before the newest moment", () => {
    expect(parseTime("12.5", 60)).toBe(12.5);
    expect(parseTime(" 1:02,5 s ", 90)).toBe(62.5);
    expect(parseTime("-17.7", 60)).toBeCloseTo(42.3);
    expect(parseTime("−2", 60)).toBe(58);
    for (const text of ["", "now", "1:2:3", "12e3"]) expect(parseTime(text, 60), text).toBeNull();
  });
});
