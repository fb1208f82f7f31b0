// 60 clients of mixed kinds watch one recorded flight: node tests/browser/mixed.mjs [--minutes 10] [--every 30]
// Consoles, MeshCat, viser and Foxglove, of each kind some that read nothing. Prints the server's memory over time, and compares the
// recording of the served flight with that of the headless flight of the same seed, tick by tick and channel by channel.
import { spawnSync } from "node:child_process";
import { parseArgs } from "node:util";
import { BINARY, freePort, pause, ROOT, scratch, startTwin } from "./harness.mjs";
import { foxglove, join, machine, Reader, residentMiB } from "./measure.mjs";

const { values: options } = parseArgs({ options: { minutes: { type: "string", default: "10" }, every: { type: "string", default: "30" } } });
const MINUTES = Number(options.minutes);
if (!(MINUTES > 0 && MINUTES <= 55)) throw new Error(`--minutes ${options.minutes}: a flight lasts an hour at most, so 55 minutes can be watched`);
const EVERY_S = Number(options.every);
const SCENARIO = "scenarios/hover.toml";
/** Numbers of clients that read and of clients that do not, by kind: 60 together. */
const CROWD = { console: [18, 3], meshcat: [10, 3], viser: [10, 3], foxglove: [10, 3] };
/** The server closes a client that reads nothing after 20 s; it is replaced after this time, s. */
const REPLACED_AFTER_S = 25;
/** The first two minutes are left out of the memory: the minute that every new client gets must be flown first, then buffers grow to it. */
const WARM_UP_MIN = 2;

async function metrics(url) {
  const text = await (await fetch(`${url}/metrics`)).text();
  const refused = [...text.matchAll(/^twin_refused_total\{reason="(\w+)"\} (\d+)/gm)].filter(([, , count]) => count !== "0");
  return { clients: Number(text.match(/^twin_clients (\d+)/m)[1]), refused: refused.map(([, reason, count]) => `${reason} ${count}`).join(", ") };
}

/** Slope of memory over time by least squares, KiB/min. */
function slope(samples) {
  const n = samples.length;
  const [meanT, meanM] = [0, 1].map((k) => samples.reduce((sum, one) => sum + one[k], 0) / n);
  const top = samples.reduce((sum, [t, m]) => sum + (t - meanT) * (m - meanM), 0);
  const bottom = samples.reduce((sum, [t]) => sum + (t - meanT) ** 2, 0);
  return (1024 * top) / bottom;
}

function twinOf(words) {
  const run = spawnSync(BINARY, words, { cwd: ROOT, encoding: "utf8", maxBuffer: 1 << 28 });
  return { status: run.status, text: (run.stdout + run.stderr).trim() };
}

const seconds = MINUTES * 60;
const flight = ["--set", `task.duration_s=${seconds}`, "--set", `time_limit_s=${seconds + 60}`];
const files = scratch("mixed");
const beside = await freePort();
const twin = await startTwin(SCENARIO, await freePort(), [...flight, "--foxglove-port", String(beside), "--record", files.file("served.mcap")]);
const ws = twin.url.replace("http", "ws");
const kinds = {
  console: (reads) => (reads ? Reader.connect(twin.url) : join(`${ws}/ws`, [], false)),
  meshcat: (reads) => join(`${ws}/`, [], reads),
  viser: (reads) => join(`${ws}/viser`, ["viser-v1.1.1"], reads),
  foxglove: (reads) => foxglove(beside, reads),
};
const total = Object.values(CROWD).reduce((sum, [reading, silent]) => sum + reading + silent, 0);
console.log(`machine ${machine()}; ${total} clients, ${MINUTES} min`);
try {
  const readers = [];
  let silent = [];
  for (const [kind, [reading]] of Object.entries(CROWD)) {
    for (let k = 0; k < reading; k += 1) readers.push({ kind, client: await kinds[kind](true) });
  }
  const fill = async () => {
    silent.forEach((client) => client.close());
    silent = [];
    for (const [kind, [, mute]] of Object.entries(CROWD)) for (let k = 0; k < mute; k += 1) silent.push(await kinds[kind](false));
  };
  await fill();
  console.log("min      tick   clients   server MiB   refused or ended");
  const samples = [];
  const started = Date.now();
  let [due, replaced] = [0, 0];
  let state;
  do {
    await pause(500);
    const elapsedS = (Date.now() - started) / 1e3;
    if (elapsedS - replaced >= REPLACED_AFTER_S) {
      replaced = elapsedS;
      await fill();
    }
    state = await (await fetch(`${twin.url}/api/state`)).json();
    const memory = residentMiB(twin.pid);
    samples.push([elapsedS / 60, memory]);
    if (elapsedS >= due || state.verdict) {
      due += EVERY_S;
      const { clients, refused } = await metrics(twin.url);
      console.log(`${(elapsedS / 60).toFixed(1).padStart(4)} ${String(state.tick).padStart(8)} ${String(clients).padStart(9)} ${memory.toFixed(1).padStart(12)}   ${refused}`);
    }
  } while (!state.verdict);
  const late = samples.filter(([minute]) => minute >= Math.min(WARM_UP_MIN, MINUTES / 2));
  const sizes = late.map(([, memory]) => memory);
  console.log(`memory after the first ${Math.min(WARM_UP_MIN, MINUTES / 2)} min: ${Math.min(...sizes).toFixed(1)} to ${Math.max(...sizes).toFixed(1)} MiB, slope ${slope(late).toFixed(1)} KiB/min`);
  const consoles = readers.filter(({ kind }) => kind === "console").map(({ client }) => client);
  console.log(`ticks taken / lost by ${consoles.length} reading consoles: ${consoles.reduce((sum, { ticks }) => sum + ticks, 0)} / ${consoles.reduce((sum, { gapTicks }) => sum + gapTicks, 0)}`);
  const lost = readers.filter(({ kind, client }) => kind !== "console" && client.closed);
  console.log(`reading viewers that lost their connection: ${lost.length}`);
  console.log(`verdict: ${state.verdict}: ${state.reason}`);
  readers.forEach(({ client }) => client.close());
  silent.forEach((client) => client.close());
} finally {
  await twin.stop();
}
const headless = twinOf(["fly", SCENARIO, ...flight, "--headless", "--record", files.file("headless.mcap")]);
console.log(`headless: ${headless.text.split("\n").find((line) => line.includes("seed")) ?? headless.text}`);
const { status, text } = twinOf(["diff", files.file("served.mcap"), files.file("headless.mcap")]);
console.log(`twin diff served headless (status ${status}): ${text}`);
files.remove();
