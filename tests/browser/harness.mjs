// Starts the real binary and a browser, and waits for conditions.
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");
export const BINARY = path.resolve(ROOT, process.env.TWIN_BIN ?? "target/release/twin");
/** Folder of the stock viewers that `twin viewers fetch --dir target/viewers --drake` downloads. */
export const VIEWERS = path.resolve(ROOT, process.env.TWIN_VIEWERS ?? "target/viewers");
/** Messages of the browser about the machine, the stock clients or a missing server, which are no faults of our pages. */
export const NOISE = /GPU stall|swiftshader|WebGL|GroupMarkerNotSet|deprecated|favicon|ERR_INTERNET_DISCONNECTED/i;
const BROWSER = process.env.CHROMIUM ?? "/usr/bin/chromium";
const START_WITHIN_MS = 30_000;
const FLAGS = [
  "--headless",
  "--no-sandbox",
  "--disable-quic",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  // As on a desktop without a graphics card, WebGL runs in software and the page is composed on the processor.
  "--disable-gpu-compositing",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--no-first-run",
];

export async function launchBrowser() {
  if (!existsSync(BROWSER)) throw new Error(`no browser at ${BROWSER}: install chromium or set CHROMIUM`);
  return chromium.launch({ executablePath: BROWSER, args: FLAGS });
}

/** A folder for the output of a test file; call `remove` at the end. */
export function scratch(name) {
  const folder = mkdtempSync(path.join(tmpdir(), `twin-${name}-`));
  return { folder, file: (inside) => path.join(folder, inside), remove: () => rmSync(folder, { recursive: true, force: true }) };
}

/** Runs `twin WORDS…` to its end; throws unless it ends with one of `statuses`. Returns the text that it printed. */
export function runTwin(words, statuses = [0]) {
  const run = spawnSync(BINARY, words, { cwd: ROOT, encoding: "utf8" });
  if (!statuses.includes(run.status)) throw new Error(`twin ${words.join(" ")} ended with ${run.status}: ${run.stderr}`);
  return run.stdout;
}

/** A free port of the loopback interface. */
export function freePort() {
  return new Promise((resolve, reject) => {
    const probe = createServer();
    probe.on("error", reject);
    probe.listen(0, "127.0.0.1", () => {
      const { port } = probe.address();
      probe.close(() => resolve(port));
    });
  });
}

/** Starts `twin fly SCENARIO --port PORT …` and waits until it answers. */
export function startTwin(scenario, port, flags = []) {
  return start("fly", scenario, port, flags);
}

/** Starts `twin mirror RECORDING --port PORT …` and waits until it answers. */
export function startMirror(recording, port, flags = []) {
  return start("mirror", recording, port, flags);
}

async function start(command, subject, port, flags) {
  if (!existsSync(BINARY)) throw new Error(`no binary at ${BINARY}: build it with cargo build --release or set TWIN_BIN`);
  const child = spawn(BINARY, [command, subject, "--port", String(port), ...flags], { cwd: ROOT, stdio: ["ignore", "pipe", "pipe"] });
  let said = "";
  const hear = (chunk) => (said = (said + chunk).slice(-4000));
  child.stdout.on("data", hear);
  child.stderr.on("data", hear);
  const ended = new Promise((resolve) => child.once("exit", resolve));
  const url = `http://127.0.0.1:${port}`;
  const ready = async () => {
    if (child.exitCode !== null) throw new Error(`twin ended with ${child.exitCode}:\n${said}`);
    return fetch(`${url}/api/health`).then((answer) => answer.ok, () => false);
  };
  await until(ready, START_WITHIN_MS, () => `twin answers on port ${port}; it said:\n${said}`);
  const stop = async () => {
    child.kill("SIGKILL");
    await ended;
  };
  return { url, port, pid: child.pid, stop };
}

/** Waits until `condition` returns a true value, and returns this value. */
export async function until(condition, withinMs, what) {
  const give = Date.now() + withinMs;
  for (;;) {
    const result = await condition();
    if (result) return result;
    if (Date.now() > give) throw new Error(`not within ${withinMs} ms: ${typeof what === "function" ? what() : what}`);
    await pause(50);
  }
}

export function pause(ms) {
  return new Promise((resolve) => setTimeout(resolve, ms));
}

/** Opens a page in its own context and waits until `ready` holds in it. Collects the page's console messages and requests. */
export async function openPage(browser, url, ready, { kinds = ["error"], withinMs = 60_000, ...options } = {}) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  const [complaints, asked] = [[], []];
  page.on("console", (message) => kinds.includes(message.type()) && complaints.push(`${message.text()} (${message.location().url})`));
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("request", (request) => asked.push(request.url()));
  await page.goto(url, { waitUntil: "commit" });
  await until(() => page.evaluate(ready), withinMs, () => `${url} is ready; it said ${complaints.join(" | ")}`);
  return { page, complaints, asked, close: () => context.close() };
}

/** Opens the console in the layout with every gain, and waits until it shows a flight. */
export function openConsole(browser, url, { layout = "tune", ...options } = {}) {
  const shows = () => (window.__twin?.lastTick ?? -1) >= 0;
  const look = { viewport: { width: 1280, height: 720 }, colorScheme: "dark" };
  return openPage(browser, `${url}/#${layout}`, shows, { ...look, kinds: ["error", "warning"], withinMs: 20_000, ...options });
}

/**
 * Starts the flight anew, holds it, and opens the console on it; `send` sends a message to the server. A page learns the state of a flight
 * from its first telemetry, so the flight is stepped until the page has some.
 */
export async function openHeld(browser, url, send, options = {}) {
  send({ type: "restart", seed: null, scenario: null });
  send({ type: "pause", paused: true });
  const nudge = setInterval(() => send({ type: "step", ticks: 1 }), 1000);
  return openConsole(browser, url, options).finally(() => clearInterval(nudge));
}

/** The values that the page shows. */
export function shown(page) {
  return page.evaluate(() => {
    const { state, connected, stale, scenario, lastTick, gains, preset, bodies, resets, rows, gapTicks } = window.__twin;
    return { state, connected, stale, scenario, lastTick, gains, preset, bodies, resets, rows, gapTicks };
  });
}
