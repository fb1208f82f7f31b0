import { describe, expect, it } from "vitest";
import { decodeTelemetry } from "./decode";

// A frame written by hand, byte by byte, from the text of the protocol: two rows of three channels, one body, one contact.
function frame(): ArrayBuffer {
  const floats = [1, 2, 3, 4, 5, NaN, /* body */ 0.5, 1.5, 2.5, 1, 0, 0, 0, /* reference */ 9, 8, 7, 0, 1, 0, 0, /* contact */ 1, 2, 3, 0, 0, 12, /* spectrum */ 5, 0.5];
  const frame = new ArrayBuffer(44 + 4 * floats.length);
  const view = new DataView(frame);
  view.setUint8(0, 0xc1);
  view.setUint8(1, 2);
  view.setUint16(2, 513, true);
  view.setUint32(4, 70_000, true);
  view.setUint16(8, 2, true);
  view.setUint16(10, 3, true);
  view.setUint16(12, 1, true);
  view.setUint16(14, 1, true);
  view.setUint32(16, 6, true);
  view.setUint32(20, 1, true);
  view.setFloat64(24, 700.02, true);
  view.setFloat64(32, 12.5, true);
  view.setUint16(40, 2, true);
  floats.forEach((value, i) => view.setFloat32(44 + 4 * i, value, true));
  return frame;
}

describe("decodeTelemetry", () => {
  it("reads every field of the header and every block", () => {
    const t = decodeTelemetry(frame());
    expect(t).toMatchObject({ schemaId: 513, firstTick: 70_000, rows: 2, channelCount: 3, gap: 6, reset: true, tSim: 700.02, tWall: 12.5 });
    expect([...t.channels]).toEqual([1, 2, 3, 4, 5, NaN]);
    expect([...t.poses]).toEqual([0.5, 1.5, 2.5, 1, 0, 0, 0]);
    expect([...t.reference]).toEqual([9, 8, 7, 0, 1, 0, 0]);
    expect([...t.contacts]).toEqual([1, 2, 3, 0, 0, 12]);
    expect([...t.spectrum]).toEqual([5, 0.5]);
  });

  it("refuses a frame cut short, one too long, another magic and another version", () => {
    const whole = frame();
    expect(() => decodeTelemetry(whole.slice(0, 20))).toThrow("20 bytes");
    expect(() => decodeTelemetry(whole.slice(0, whole.byteLength - 4))).toThrow("announces");
    const magic = whole.slice(0);
    new Uint8Array(magic)[0] = 0x7b;
    expect(() => decodeTelemetry(magic)).toThrow("0x7b");
    const version = whole.slice(0);
    new Uint8Array(version)[1] = 1;
    expect(() => decodeTelemetry(version)).toThrow("version 1");
  });
});
