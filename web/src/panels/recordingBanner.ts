// Says at the top of the picture that the recording of this flight failed, loses ticks, or may run out of space.
import type { RecordingStatus } from "../protocol";
import { byId, setText } from "./dom";

/** What an operator has to know about the recording; empty if all is well or nothing is recorded. */
export function recordingText(recording: RecordingStatus | null): string {
  if (recording === null) return "";
  const lost = `${recording.dropped_ticks} ${recording.dropped_ticks === 1 ? "tick is" : "ticks are"} lost`;
  if (recording.state === "failed") return `${recording.error ?? `${recording.file}: the recording failed`}. The flight goes on; ${lost} so far.`;
  if (recording.dropped_ticks > 0) return `${recording.file}: the disk is too slow; ${lost}.`;
  return recording.state === "recording" ? (recording.warning ?? "") : "";
}

export class RecordingBanner {
  private readonly root = byId("recording-banner");

  update(recording: RecordingStatus | null): void {
    const text = recordingText(recording);
    this.root.hidden = text === "";
    setText(this.root, text);
  }
}
