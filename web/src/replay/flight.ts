// Unpacks the flight that `twin export html` put into the page: base64 of a gzip. Its content is a JSON head and telemetry frames,
// each after its length in bytes (32 bits, little-endian).
import { decodeTelemetry, type Telemetry } from "../link/decode";
import type { Hello } from "../protocol";

/** A demand of the scenario that the flight did not meet. */
export interface Failure {
  at_s: number;
  text: string;
  /** Channels that show it: the signal, then its limits; empty if the demand limits no number of a tick. */
  channels: string[];
}

export interface Head {
  hello: Hello;
  title: string;
  seed: number;
  verdict: string;
  reason: string;
  state_hash: string;
  /** Version and commit of the program that wrote the page. */
  program: string;
  passed: boolean | null;
  failures: Failure[];
  /** Time of the flight at which the page opens, s. */
  opens_at_s: number;
}

export interface Flight {
  head: Head;
  frames: Telemetry[];
}

/** Whether the flight met its demands, in words; without a judgement its verdict. */
export function outcome({ passed, verdict, failures }: Pick<Head, "passed" | "verdict" | "failures">): string {
  if (passed === null) return verdict;
  if (passed) return `✓ ${verdict}`;
  return `✕ ${failures.length} ${failures.length === 1 ? "demand" : "demands"} not met`;
}

const LENGTH_BYTES = 4;

/** Unpacks the text that stands in the page. */
export async function unpack(base64: string): Promise<Flight> {
  const packed = Uint8Array.from(atob(base64.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return split(await new Response(stream).arrayBuffer());
}

/** Splits the unpacked bytes into head and frames. Throws if they are cut off. */
export function split(bytes: ArrayBuffer): Flight {
  const view = new DataView(bytes);
  let at = 0;
  const part = (): ArrayBuffer => {
    const from = at + LENGTH_BYTES;
    at = from + view.getUint32(at, true);
    if (at > bytes.byteLength) throw new Error(`the flight of this page is cut off at byte ${bytes.byteLength}`);
    return bytes.slice(from, at);
  };
  const head = JSON.parse(new TextDecoder().decode(part())) as Head;
  const frames: Telemetry[] = [];
  while (at < bytes.byteLength) frames.push(decodeTelemetry(part()));
  return { head, frames };
}
