import { describe, expect, it } from "vitest";
import type { Failure } from "./flight";
import { outcome } from "./flight";

const failure: Failure = { at_s: 1, text: "", channels: [] };

describe("outcome", () => {
  it("of a test that failed is no verdict of the flight, which may well have been completed", () => {
    expect(outcome({ passed: false, verdict: "completed", failures: [failure] })).toBe("✕ 1 demand not met");
    expect(outcome({ passed: false, verdict: "completed", failures: [failure, failure] })).toBe("✕ 2 demands not met");
    expect(outcome({ passed: true, verdict: "completed", failures: [] })).toBe("✓ completed");
    expect(outcome({ passed: null, verdict: "unfinished", failures: [] })).toBe("unfinished");
  });
});
