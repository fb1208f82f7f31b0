// Measures the console and prints the figures; it asserts nothing: node tests/browser/bench.mjs [--seconds 10]
import { parseArgs } from "node:util";
import { gzipSync } from "node:zlib";
import { freePort, launchBrowser, openConsole, pause, startTwin } from "./harness.mjs";
import { between, clockOffset, lateness, LONG_FLIGHT, machine, quantile, Reader, stalled } from "./measure.mjs";

const { values: options } = parseArgs({ options: { seconds: { type: "string", default: "10" } } });
const SECONDS = Number(options.seconds);
const WATCHERS = 80;
const STALLED = 20;
/** Rounds without and with the crowd alternate, so that other load of the machine affects both alike. */
const ROUNDS = 3;
const FULL_HD = { viewport: { width: 1920, height: 1080 } };

const round = (value, digits = 2) => Number(value.toFixed(digits));
const say = (name, value, aim) => console.log(`${name.padEnd(44)} ${value}${aim ? `   (aim ${aim})` : ""}`);

/** Size of all files that the page loaded, compressed with gzip, bytes. */
async function bundle(page, url) {
  const loaded = await page.evaluate(() => performance.getEntriesByType("resource").map(({ name }) => name));
  const parts = [url, ...loaded.filter((name) => /\.(js|css)$/.test(name))];
  const sizes = await Promise.all(parts.map(async (part) => gzipSync(Buffer.from(await (await fetch(part)).arrayBuffer())).length));
  return { bytes: sizes.reduce((sum, size) => sum + size, 0), parts: parts.length };
}

/** Times of drawn frames and delays of telemetry over some seconds, as the page itself records them. */
function watch(page, seconds) {
  return page.evaluate((seconds) => new Promise((resolve) => {
    const deliveries = [];
    const gaps = [];
    const started = performance.now();
    const pictures = () => globalThis.__twin.scene.pictures;
    const drawnBefore = pictures();
    let last = started;
    const frame = (now) => {
      gaps.push(now - last);
      last = now;
      const newest = globalThis.__twin.delivery;
      if (newest !== null && newest.tick !== deliveries.at(-1)?.tick) deliveries.push(newest);
      if (now - started < seconds * 1e3) requestAnimationFrame(frame);
      else resolve({ deliveries, gaps: gaps.slice(1), spanMs: now - started, pictures: pictures() - drawnBefore });
    };
    requestAnimationFrame(frame);
  }), seconds);
}

async function page(browser, url) {
  const opened = await openConsole(browser, url, FULL_HD);
  await pause(3000);
  const paint = await opened.page.evaluate(() => performance.getEntriesByType("paint").find(({ name }) => name === "first-contentful-paint")?.startTime ?? NaN);
  const { bytes, parts } = await bundle(opened.page, url);
  const drawn = await watch(opened.page, SECONDS);
  const { offsetMs, tripMs } = await clockOffset(url);
  const charts = await opened.page.evaluate(() => globalThis.__twin.charts.panels.length);
  const software = await opened.page.evaluate(() => {
    const gl = document.createElement("canvas").getContext("webgl2");
    return gl.getParameter(gl.getExtension("WEBGL_debug_renderer_info").UNMASKED_RENDERER_WEBGL);
  });
  await opened.close();
  const came = drawn.deliveries.map(({ leftMs, cameMs }) => cameMs - leftMs - offsetMs);
  const taken = drawn.deliveries.map(({ leftMs, takenMs }) => takenMs - leftMs - offsetMs);
  say(`bundle of ${parts} files, kB gzip`, round(bytes / 1e3, 1), "<= 300");
  say("renderer", software);
  say("charts", charts);
  say("first paint, ms", round(paint, 0), "<= 1000");
  say("frames/s at 1920x1080", round((drawn.gaps.length * 1e3) / drawn.spanMs, 1), ">= 30");
  say("  of them with a new 3-D picture", round((drawn.pictures * 1e3) / drawn.spanMs, 1));
  say("frame interval p50 / p95, ms", `${round(quantile(drawn.gaps, 0.5), 1)} / ${round(quantile(drawn.gaps, 0.95), 1)}`);
  say("server to socket p50 / p95, ms", `${round(quantile(came, 0.5))} / ${round(quantile(came, 0.95))}`);
  say("server to page p50 / p95, ms", `${round(quantile(taken, 0.5))} / ${round(quantile(taken, 0.95))}`, "p95 <= 20");
  say("  clocks agree within, ms", round(tripMs / 2));
}

/** Measures how late ticks begin without clients, and with a crowd in which some clients read nothing. */
async function crowd(url) {
  const sums = { alone: [], crowded: [] };
  let lost = 0;
  let taken = 0;
  for (let turn = 0; turn < ROUNDS; turn += 1) {
    const alone = await lateness(url);
    await pause(SECONDS * 1e3);
    sums.alone.push(between(alone, await lateness(url)));
    const clients = [];
    for (let k = 0; k < WATCHERS; k += 1) clients.push(await Reader.connect(url));
    for (let k = 0; k < STALLED; k += 1) clients.push(await stalled(url));
    await pause(1000);
    const crowded = await lateness(url);
    await pause(SECONDS * 1e3);
    sums.crowded.push(between(crowded, await lateness(url)));
    for (const client of clients.slice(0, WATCHERS)) {
      lost += client.gapTicks;
      taken += client.ticks;
    }
    clients.forEach((client) => client.close());
    await pause(1000);
  }
  for (const [name, stretches] of Object.entries(sums)) {
    const mean = (key) => round((100 * stretches.reduce((sum, one) => sum + one[key] * one.ticks, 0)) / stretches.reduce((sum, one) => sum + one.ticks, 0));
    const clients = name === "alone" ? "no client" : `${WATCHERS + STALLED} clients, ${STALLED} stalled`;
    say(`tick late <= 0.25 / 1 / 5 / 25 ms, %: ${clients}`, ["within_0_25_ms", "within_1_ms", "within_5_ms", "within_25_ms"].map(mean).join(" / "));
  }
  say(`ticks taken / lost by the ${WATCHERS} that read`, `${taken} / ${lost}`);
}

say("machine", machine());
const browser = await launchBrowser();
const twin = await startTwin("scenarios/hover.toml", await freePort(), LONG_FLIGHT);
try {
  await page(browser, twin.url);
  await browser.close();
  await crowd(twin.url);
} finally {
  await browser.close();
  await twin.stop();
}
