import { describe, expect, it } from "vitest";
import type { RecordingStatus } from "../protocol";
import { recordingText } from "./recordingBanner";

const well: RecordingStatus = { file: "f.mcap", state: "recording", bytes: 10, ticks: 3, dropped_ticks: 0, error: null, warning: null };

describe("recordingText", () => {
  it("is empty while all is well, and without a recording", () => {
    expect(recordingText(null)).toBe("");
    expect(recordingText(well)).toBe("");
    expect(recordingText({ ...well, state: "finished", warning: "little space" })).toBe("");
  });

  it("gives the cause of a failure and counts what is lost", () => {
    const failed: RecordingStatus = { ...well, state: "failed", dropped_ticks: 1, error: "f.mcap: the recording failed: No space left on device" };
    expect(recordingText(failed)).toBe("f.mcap: the recording failed: No space left on device. The flight goes on; 1 tick is lost so far.");
    expect(recordingText({ ...well, dropped_ticks: 7 })).toBe("f.mcap: the disk is too slow; 7 ticks are lost.");
  });

  it("shows a warning before anything is lost", () => expect(recordingText({ ...well, warning: "little space" })).toBe("little space"));
});
