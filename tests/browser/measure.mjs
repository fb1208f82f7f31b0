// Tools to measure the server: clients that read or stall, the server's own histogram of delays, and memory.
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import WebSocket from "ws";

/** Flags of `twin fly` for the longest flight that a scenario allows. */
export const LONG_FLIGHT = ["--set", "task.duration_s=3600", "--set", "time_limit_s=3600"];

/** A client that reads everything, and counts the ticks that it received and those that the server dropped. */
export class Reader {
  ticks = 0;
  gapTicks = 0;
  #schema = -1;

  static async connect(url) {
    const made = new Reader();
    made.socket = await opened(url, (data, binary) => (binary ? made.#telemetry(data) : made.#text(data)));
    return made;
  }

  close() {
    this.socket.terminate();
  }

  #text(data) {
    const message = JSON.parse(data);
    if (message.type === "hello") this.#schema = message.schema_id;
  }

  #telemetry(data) {
    if (data.readUInt16LE(2) !== this.#schema) return;
    this.ticks += data.readUInt16LE(8);
    this.gapTicks += data.readUInt32LE(16);
  }
}

/** Connects a client that never reads from its socket. */
export async function stalled(url) {
  const socket = await opened(url);
  socket.pause();
  return { close: () => socket.terminate() };
}

/** Opens a socket. `hear` listens before the first message, because the `hello` may arrive together with the answer to the upgrade. */
function opened(url, hear = () => {}) {
  const socket = new WebSocket(url.replace("http", "ws") + "/ws");
  socket.on("error", () => {});
  socket.on("message", hear);
  return new Promise((resolve, reject) => {
    socket.once("open", () => resolve(socket));
    socket.once("error", reject);
  });
}

/** The histogram of delays of ticks from `/metrics`: cumulative counts by upper edge (ms) since the server's start. */
export async function lateness(url) {
  const text = await (await fetch(`${url}/metrics`)).text();
  const counts = [...text.matchAll(/^twin_tick_lateness_seconds_bucket\{le="([^"]+)"\} (\d+)/gm)];
  return new Map(counts.map(([, edge, count]) => [edge === "+Inf" ? Infinity : Number(edge) * 1e3, Number(count)]));
}

/** Number of ticks between two readings of the histogram, and the share of them below each upper edge. */
export function between(before, after) {
  const ticks = after.get(Infinity) - before.get(Infinity);
  const within = (edge) => (after.get(edge) - before.get(edge)) / ticks;
  return { ticks, within_0_25_ms: within(0.25), within_1_ms: within(1), within_5_ms: within(5), within_25_ms: within(25) };
}

/** Offset from the server's uptime to the page's clock, ms, from the quickest of `tries` requests. */
export async function clockOffset(url, tries = 30) {
  let best = { tripMs: Infinity, offsetMs: NaN };
  for (let k = 0; k < tries; k += 1) {
    const asked = Date.now() + fraction();
    const { uptime_s: uptimeS } = await (await fetch(`${url}/api/health`)).json();
    const answered = Date.now() + fraction();
    if (answered - asked < best.tripMs) best = { tripMs: answered - asked, offsetMs: (asked + answered) / 2 - uptimeS * 1e3 };
  }
  return best;
}

/** Fraction of a millisecond from the finer clock, because `Date.now` gives whole milliseconds. */
function fraction() {
  return performance.timeOrigin + performance.now() - Date.now();
}

export function quantile(values, share) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
}

/** Resident memory of a process, MiB. */
export function residentMiB(pid) {
  const line = readFileSync(`/proc/${pid}/status`, "utf8").match(/^VmRSS:\s+(\d+) kB/m);
  return Number(line[1]) / 1024;
}

/** Description of the machine, so that each figure says where it was measured. */
export function machine() {
  const model = readFileSync("/proc/cpuinfo", "utf8").match(/^model name\s*:\s*(.*)$/m)?.[1] ?? "unknown processor";
  const cores = execFileSync("nproc", { encoding: "utf8" }).trim();
  return `${cores} x ${model}`;
}

/** Topics to which Foxglove clients subscribe. MeshCat and viser get the newest poses only, Foxglove gets every row. */
const TOPICS = ["/tf", "/scene", "/twin/telemetry"];

/** A client of any kind that counts its frames; unless it `reads`, it reads nothing once it is connected. */
export function join(url, subprotocols, reads, hear = () => {}) {
  const socket = new WebSocket(url, subprotocols, { perMessageDeflate: false });
  const client = { frames: 0, closed: false, close: () => socket.terminate() };
  socket.on("error", () => {});
  socket.on("close", () => (client.closed = true));
  socket.on("message", (data, binary) => {
    client.frames += 1;
    if (!binary) hear(socket, data);
  });
  return new Promise((resolve, reject) => {
    socket.once("error", reject);
    socket.once("open", () => {
      if (!reads) socket.pause();
      resolve(client);
    });
  });
}

/** A Foxglove client that subscribes to those topics when the server advertises them; afterwards it reads only if `reads`. */
export function foxglove(port, reads) {
  let id = 0;
  return join(`ws://127.0.0.1:${port}`, ["foxglove.sdk.v1"], true, (socket, data) => {
    const said = JSON.parse(data);
    if (said.op !== "advertise") return;
    const channels = said.channels.filter(({ topic }) => TOPICS.includes(topic));
    socket.send(JSON.stringify({ op: "subscribe", subscriptions: channels.map((channel) => ({ id: (id += 1), channelId: channel.id })) }));
    if (!reads && id >= TOPICS.length) socket.pause();
  });
}
