// Measures the memory of server and page, and lost ticks, in a long flight with eight clients: node tests/browser/soak.mjs [--minutes 30]
import { parseArgs } from "node:util";
import { freePort, launchBrowser, openConsole, pause, startTwin } from "./harness.mjs";
import { LONG_FLIGHT, machine, Reader, residentMiB } from "./measure.mjs";

const { values: options } = parseArgs({ options: { minutes: { type: "string", default: "30" }, every: { type: "string", default: "60" } } });
const MINUTES = Number(options.minutes);
if (!(MINUTES > 0 && MINUTES <= 55)) throw new Error(`--minutes ${options.minutes}: a flight lasts an hour at most, so 55 minutes can be watched`);
const EVERY_S = Number(options.every);
/**
 * Chromium's warning that a picture was read before it was computed. Without a graphics card every read waits for the processor, but
 * in Chromium's own process and not in the page's. With a card the page reads no picture at all.
 */
const READ_BACK = /GPU stall due to ReadPixels/;
/** Number of reading clients; with the page there are eight clients. */
const READERS = 7;

console.log(`machine ${machine()}; ${MINUTES} min at 100 Hz, ${READERS} reading clients and one page`);
const browser = await launchBrowser();
const twin = await startTwin("scenarios/hover.toml", await freePort(), LONG_FLIGHT);
try {
  const readers = await Promise.all(Array.from({ length: READERS }, () => Reader.connect(twin.url)));
  const { page, complaints } = await openConsole(browser, twin.url);
  const devtools = await page.context().newCDPSession(page);
  await devtools.send("HeapProfiler.enable");
  const heapMiB = async () => {
    await devtools.send("HeapProfiler.collectGarbage");
    return (await devtools.send("Runtime.getHeapUsage")).usedSize / 2 ** 20;
  };
  const shown = () => page.evaluate(() => ({ rows: globalThis.__twin.rows, lost: globalThis.__twin.gapTicks, stale: globalThis.__twin.stale }));
  console.log("min   ticks    server MiB   page heap MiB   page rows   page lost   readers: fewest ticks   lost");
  const started = Date.now();
  for (;;) {
    const minutes = (Date.now() - started) / 60e3;
    const { tick } = await (await fetch(`${twin.url}/api/state`)).json();
    const { rows, lost } = await shown();
    const fewest = Math.min(...readers.map(({ ticks }) => ticks));
    const lostByReaders = readers.reduce((sum, { gapTicks }) => sum + gapTicks, 0);
    console.log(
      [minutes.toFixed(1).padStart(4), String(tick).padStart(8), residentMiB(twin.pid).toFixed(1).padStart(12), (await heapMiB()).toFixed(1).padStart(15), String(rows).padStart(11), String(lost).padStart(11), String(fewest).padStart(23), String(lostByReaders).padStart(6)].join(" "),
    );
    if (minutes >= MINUTES) break;
    await pause(Math.min(EVERY_S * 1e3, (MINUTES - minutes) * 60e3 + 50));
  }
  const ours = complaints.filter((text) => !READ_BACK.test(text));
  console.log(`the page complained about: ${ours.length === 0 ? "nothing" : ours.join(" | ")}`);
  console.log(`left out: ${complaints.length - ours.length} times "GPU stall due to ReadPixels"`);
  readers.forEach((reader) => reader.close());
} finally {
  await browser.close();
  await twin.stop();
}
