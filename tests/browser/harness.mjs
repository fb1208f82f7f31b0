// Starts the real binary and a browser, and waits for things to become true.
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");
export const BINARY = path.resolve(ROOT, process.env.TWIN_BIN ?? "target/release/twin");
/** The stock viewers, as `twin viewers fetch --dir target/viewers --drake` leaves them. */
export const VIEWERS = path.resolve(ROOT, process.env.TWIN_VIEWERS ?? "target/viewers");
/** What the stock clients, and pages without a server, say of the machine and of themselves, not of us. */
export const NOISE = /GPU stall|swiftshader|WebGL|GroupMarkerNotSet|deprecated|favicon|ERR_INTERNET_DISCONNECTED/i;
const BROWSER = process.env.CHROMIUM ?? "/usr/bin/chromium";
const START_WITHIN_MS = 30_000;
const FLAGS = [
  "--headless",
  "--no-sandbox",
  "--disable-quic",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  // As a desktop without a graphics card does: WebGL in software, and the page put together without it.
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

/** A folder for what a test file makes; `remove` it at the end. */
export function scratch(name) {
  const folder = mkdtempSync(path.join(tmpdir(), `twin-${name}-`));
  return { folder, file: (inside) => path.join(folder, inside), remove: () => rmSync(folder, { recursive: true, force: true }) };
}

/** `twin WORDS…` to its end with one of these statuses; what it printed. */
export function runTwin(words, statuses = [0]) {
  const run = spawnSync(BINARY, words, { cwd: ROOT, encoding: "utf8" });
  if (!statuses.includes(run.status)) throw new Error(`twin ${words.join(" ")} ended with ${run.status}: ${run.stderr}`);
  return run.stdout;
}

/** A port of the loopback that was free just now. */
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

/** `twin fly SCENARIO --port PORT …`, ready to answer. */
export function startTwin(scenario, port, flags = []) {
  return start("fly", scenario, port, flags);
}

/** `twin mirror RECORDING --port PORT …`, ready to answer. */
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

/** Waits until `condition` gives something true, and returns it. */
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

/** A page in a context of its own, once `ready` holds in it; it keeps what the browser complained about and asked for. */
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

/** A page on the console, once it shows a flight. */
export function openConsole(browser, url, options = {}) {
  const shows = () => (window.__twin?.lastTick ?? -1) >= 0;
  const look = { viewport: { width: 1280, height: 720 }, colorScheme: "dark" };
  return openPage(browser, url, shows, { ...look, kinds: ["error", "warning"], withinMs: 20_000, ...options });
}

/** Values that the page shows. */
export function shown(page) {
  return page.evaluate(() => {
    const { state, connected, stale, scenario, lastTick, gains, preset, bodies, resets, rows, gapTicks } = window.__twin;
    return { state, connected, stale, scenario, lastTick, gains, preset, bodies, resets, rows, gapTicks };
  });
}
