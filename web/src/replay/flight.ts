// The flight as `twin export html` put it into the page: base64 of a gzip of a length, a JSON head of that length and
// telemetry frames, each after its own length. Lengths are 32 bits, little-endian.
import { decodeTelemetry, type Telemetry } from "../link/decode";
import type { Hello } from "../protocol";

/** A demand of the scenario that the flight did not keep. */
export interface Failure {
  at_s: number;
  text: string;
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
  /** Where the page opens, s. */
  opens_at_s: number;
}

export interface Flight {
  head: Head;
  frames: Telemetry[];
}

const LENGTH_BYTES = 4;

/** Unpacks what stands in the page. */
export async function unpack(base64: string): Promise<Flight> {
  const packed = Uint8Array.from(atob(base64.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return split(await new Response(stream).arrayBuffer());
}

/** Takes the unpacked bytes apart. */
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
