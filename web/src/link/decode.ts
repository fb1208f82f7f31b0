// Binary telemetry: a 44-byte little-endian header, then rows of channels, body poses, the reference pose, contacts,
// the covariance's spectrum.
// The views share the frame's memory: nothing is copied.

export const HEADER_BYTES = 44;
export const MAGIC = 0xc1;
export const VERSION = 2;
const POSE_FLOATS = 7;
const CONTACT_FLOATS = 6;
const FLAG_RESET = 1;

export interface Telemetry {
  schemaId: number;
  /** Tick number of the first row. */
  firstTick: number;
  rows: number;
  channelCount: number;
  /** Number of ticks that the server dropped for this client just before `firstTick`. */
  gap: number;
  /** Whether the flight has started anew, so that all older frames belong to another flight. */
  reset: boolean;
  /** Simulated time of the newest row, s. */
  tSim: number;
  /** Time at which the server sent the frame, on the server's clock (its uptime), s. */
  tWall: number;
  /** Values of the channels, `rows` x `channelCount`. */
  channels: Float32Array;
  /** Pose of each moving body at the newest tick, in the order of the scene: x y z (m), then the quaternion w x y z. */
  poses: Float32Array;
  /** Pose of the vehicle's root in the reference, in the same layout as one body. */
  reference: Float32Array;
  /** Point (m) and force (N) of each contact, in the world. */
  contacts: Float32Array;
  /** Eigenvalues of the adapter's covariance, largest first. */
  spectrum: Float32Array;
}

/** Decodes one frame. Throws an Error that says what was found and what was expected. */
export function decodeTelemetry(frame: ArrayBuffer): Telemetry {
  if (frame.byteLength < HEADER_BYTES) {
    throw new Error(`telemetry frame of ${frame.byteLength} bytes is shorter than its ${HEADER_BYTES}-byte header`);
  }
  const head = new DataView(frame);
  const magic = head.getUint8(0);
  const version = head.getUint8(1);
  if (magic !== MAGIC || version !== VERSION) {
    throw new Error(`telemetry frame starts with 0x${magic.toString(16)}, version ${version}; expected 0xc1, version ${VERSION}`);
  }
  const rows = head.getUint16(8, true);
  const channelCount = head.getUint16(10, true);
  const bodyCount = head.getUint16(12, true);
  const contactCount = head.getUint16(14, true);
  const spectrumCount = head.getUint16(40, true);
  const floats = rows * channelCount + (bodyCount + 1) * POSE_FLOATS + contactCount * CONTACT_FLOATS + spectrumCount;
  const expected = HEADER_BYTES + 4 * floats;
  if (frame.byteLength !== expected) {
    throw new Error(`telemetry frame is ${frame.byteLength} bytes; its header announces ${expected}`);
  }
  let offset = HEADER_BYTES;
  const take = (count: number): Float32Array => {
    const view = new Float32Array(frame, offset, count);
    offset += 4 * count;
    return view;
  };
  return {
    schemaId: head.getUint16(2, true),
    firstTick: head.getUint32(4, true),
    rows,
    channelCount,
    gap: head.getUint32(16, true),
    reset: (head.getUint32(20, true) & FLAG_RESET) !== 0,
    tSim: head.getFloat64(24, true),
    tWall: head.getFloat64(32, true),
    channels: take(rows * channelCount),
    poses: take(bodyCount * POSE_FLOATS),
    reference: take(POSE_FLOATS),
    contacts: take(contactCount * CONTACT_FLOATS),
    spectrum: take(spectrumCount),
  };
}
