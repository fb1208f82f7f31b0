// Forks of a live flight, on the page and against the real server: node --test.
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import path from "node:path";
import { after, before, test } from "node:test";
import WebSocket from "ws";
import { freePort, launchBrowser, openConsole, pause, ROOT, runTwin, shown, startTwin, until } from "./harness.mjs";

const SCENARIO = "scenarios/a_300g_slow.toml";
/** Time limit of a wait, ms. A fork of a mission flies a minute and so does the flight beside it, on a machine that does other work. */
const SOON = 120_000;
const LIMIT = { timeout: 300_000 };
/** Tick at which the flight is paused: the vehicle has gripped the payload. */
const FLOWN = 900;
const SHOTS = process.env.TWIN_SHOTS;

let browser, twin, page, complaints, socket;

before(async () => {
  browser = await launchBrowser();
  twin = await startTwin(SCENARIO, await freePort(), ["--start-paused"]);
  socket = new WebSocket(twin.url.replace("http", "ws") + "/ws");
  await new Promise((resolve) => socket.once("open", resolve));
  socket.send(JSON.stringify({ type: "step", ticks: FLOWN }));
  ({ page, complaints } = await openConsole(browser, twin.url));
  await until(async () => (await shown(page)).lastTick === FLOWN - 1, SOON, `the page has tick ${FLOWN - 1}`);
  await page.locator("#tab-forks").click();
}, LIMIT);

after(async () => {
  socket?.terminate();
  await browser?.close();
  await twin?.stop();
});

const card = (index) => page.locator(".fork").nth(index);
/** Metrics of a fork as the page shows them: name to texts of fork, flight and difference. */
const table = async (index) => {
  await card(index).locator("table").waitFor({ timeout: SOON });
  return Object.fromEntries(await card(index).locator("tbody tr").evaluateAll((rows) => rows.map((row) => [row.dataset.metric, [...row.children].slice(1).map((cell) => cell.textContent.replace("−", "-"))])));
};

async function shot(name) {
  if (SHOTS === undefined) return;
  mkdirSync(SHOTS, { recursive: true });
  for (const [width, height] of [[1280, 720], [1920, 1080]]) {
    await page.setViewportSize({ width, height });
    await pause(1500);
    await page.screenshot({ path: path.join(SHOTS, `${name}-${width}.png`) });
  }
  await page.setViewportSize({ width: 1280, height: 720 });
}

test("an unchanged fork has no difference from the flight", LIMIT, async () => {
  assert.match(await page.locator("#fork-here").innerText(), /now/);
  await page.locator("#fork-here").click();
  const metrics = await table(0);
  assert.ok(Object.keys(metrics).length >= 5);
  for (const [name, [fork, flight, difference]] of Object.entries(metrics)) {
    assert.equal(fork, flight, name);
    assert.equal(difference, "0", name);
  }
  assert.match(await card(0).innerText(), /nothing changed/);
});

test("a fork with another payload has the metrics of the headless fork, and its lines are on the charts", LIMIT, async () => {
  await page.locator("#fork-payload").fill("500");
  await page.locator("#fork-adapter").selectOption("off");
  await page.locator("#fork-name").fill("500 g, no LRA");
  await page.locator("#fork-here").click();
  const metrics = await table(1);
  assert.equal(await card(1).locator("input").inputValue(), "500 g, no LRA");
  const flags = ["--fork-at", String(FLOWN / 100), "--set", "payload.mass_kg=0.5", "--set", "gains.adapter_on=0.0"];
  const { forks } = JSON.parse(runTwin(["fly", SCENARIO, "--headless", "--json", ...flags]));
  const four = (value) => String(Number(value.toPrecision(4)));
  for (const [name, [fork, flight]] of Object.entries(metrics)) {
    const row = forks[0].differences.find(({ metric }) => metric === name);
    assert.deepEqual([fork, flight], [row.value, row.parent].map((value) => (value === null ? "–" : four(value))), name);
  }
  const drawn = () => page.evaluate(() => window.__twin.forks.map(({ id, rows }) => [id, rows]));
  await until(async () => (await drawn()).every(([, rows]) => rows > 1000), SOON, "the page has the rows of both forks");
  await shot("forks");
});

test("a fork at the playhead begins there, refusals say why, and a dropped fork is gone", LIMIT, async () => {
  await page.locator("#fork-clear").click();
  await page.keyboard.press("p");
  await until(async () => /playhead/.test(await page.locator("#fork-here").innerText()), SOON, "the button names the playhead");
  const text = await page.locator("#fork-here").innerText();
  const at = Number(/at ([\d.]+) s/.exec(text)[1]);
  await page.locator("#fork-predictor").selectOption("persistence");
  await page.locator("#fork-here").click();
  await until(async () => (await page.locator(".fork").count()) === 3, SOON, "there is a third fork");
  assert.match(await card(2).innerText(), new RegExp(`at ${at.toFixed(2).replace(".", "\\.")} s`));
  socket.send(JSON.stringify({ type: "fork", tick: 100, set: ["seed=9"], name: "refused" }));
  await until(async () => /cannot change in the air/.test(await page.locator("#forks").innerText()), SOON, "the page says why a fork is refused");
  for (const left of [3, 2, 1, 0]) {
    await page.locator(".fork button", { hasText: "Drop" }).first().click();
    await until(async () => (await page.locator(".fork").count()) === left, SOON, `${left} forks are left`);
  }
  assert.deepEqual(complaints, []);
});
