// Measures the flight while 200 clients of every kind watch, 20 of which read nothing: node tests/browser/crowd.mjs [--seconds 10]
// It asserts nothing and prints the lateness of ticks without and with the crowd, lost ticks, and the server's memory per client.
import { parseArgs } from "node:util";
import { freePort, pause, startTwin } from "./harness.mjs";
import { between, foxglove, join, lateness, LONG_FLIGHT, machine, Reader, residentMiB, stalled } from "./measure.mjs";

const { values: options } = parseArgs({ options: { seconds: { type: "string", default: "10" }, rounds: { type: "string", default: "2" } } });
const SECONDS = Number(options.seconds);
/** Rounds without and with the crowd alternate, so that other load of the machine affects both alike. */
const ROUNDS = Number(options.rounds);
/** Numbers of clients that read and of clients that do not, by kind. */
const CROWD = { console: [80, 5], meshcat: [40, 5], viser: [40, 5], foxglove: [20, 5] };

const say = (name, value) => console.log(`${name.padEnd(52)} ${value}`);

const twins = await freePort();
const beside = await freePort();
const twin = await startTwin("scenarios/hover.toml", twins, [...LONG_FLIGHT, "--foxglove-port", String(beside)]);
const ws = twin.url.replace("http", "ws");
const kinds = {
  console: (reads) => (reads ? Reader.connect(twin.url) : stalled(twin.url)),
  meshcat: (reads) => join(`${ws}/`, [], reads),
  viser: (reads) => join(`${ws}/viser`, ["viser-v1.1.1"], reads),
  foxglove: (reads) => foxglove(beside, reads),
};

say("machine", machine());
const sums = { "no client": [], crowd: [] };
let taken = 0;
let lost = 0;
const total = Object.values(CROWD).reduce((sum, [reading, silent]) => sum + reading + silent, 0);
const silent = Object.values(CROWD).reduce((sum, [, one]) => sum + one, 0);
try {
  await pause(2000);
  for (let turn = 0; turn < ROUNDS; turn += 1) {
    const alone = await lateness(twin.url);
    await pause(SECONDS * 1e3);
    sums["no client"].push(between(alone, await lateness(twin.url)));
    const before = residentMiB(twin.pid);
    const clients = [];
    for (const [kind, [reading, mute]] of Object.entries(CROWD)) {
      for (let k = 0; k < reading + mute; k += 1) clients.push({ kind, reads: k < reading, client: await kinds[kind](k < reading) });
    }
    await pause(3000);
    const crowded = await lateness(twin.url);
    await pause(SECONDS * 1e3);
    sums.crowd.push(between(crowded, await lateness(twin.url)));
    const with_ = residentMiB(twin.pid);
    say(`turn ${turn + 1}: server MiB without / with, KiB a client`, `${before.toFixed(1)} / ${with_.toFixed(1)}, ${(((with_ - before) * 1024) / total).toFixed(0)}`);
    for (const kind of Object.keys(CROWD)) {
      const reading = clients.filter((one) => one.kind === kind && one.reads).map(({ client }) => client);
      if (kind === "console") {
        taken += reading.reduce((sum, { ticks }) => sum + ticks, 0);
        lost += reading.reduce((sum, { gapTicks }) => sum + gapTicks, 0);
      } else {
        const frames = reading.map((client) => client.frames);
        say(`turn ${turn + 1}: ${kind}: fewest / most frames, closed`, `${Math.min(...frames)} / ${Math.max(...frames)}, ${reading.filter(({ closed }) => closed).length}`);
      }
    }
    clients.forEach(({ client }) => client.close());
    await pause(1500);
  }
  for (const [name, stretches] of Object.entries(sums)) {
    const ticks = stretches.reduce((sum, one) => sum + one.ticks, 0);
    const mean = (key) => ((100 * stretches.reduce((sum, one) => sum + one[key] * one.ticks, 0)) / ticks).toFixed(2);
    const who = name === "crowd" ? `${total} clients, ${silent} stalled` : name;
    say(`tick late <= 0.25 / 1 / 5 / 25 ms, %: ${who}`, ["within_0_25_ms", "within_1_ms", "within_5_ms", "within_25_ms"].map(mean).join(" / "));
  }
  say("ticks taken / lost by the consoles that read", `${taken} / ${lost}`);
} finally {
  await twin.stop();
}
