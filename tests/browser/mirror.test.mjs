// The console of a mirrored recording: its description, seeks to any moment, and a stretch played in a loop.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { freePort, launchBrowser, openConsole, pause, runTwin, scratch, startMirror, until } from "./harness.mjs";

const FLIGHT_S = 12;
const TICK_S = 0.01;
const own = scratch("mirror");
let browser;
let twin;
let page;
let complaints;

before(async () => {
  const file = own.file("hover.mcap");
  const flags = ["--headless", "--json", "--record", file, "--set", `task.duration_s=${FLIGHT_S}`, "--set", `time_limit_s=${FLIGHT_S + 5}`];
  runTwin(["fly", "scenarios/hover.toml", ...flags]);
  browser = await launchBrowser();
  twin = await startMirror(file, await freePort(), ["--start-paused"]);
  ({ page, complaints } = await openConsole(browser, twin.url, { viewport: { width: 1440, height: 900 } }));
});

after(async () => {
  await browser?.close();
  await twin?.stop();
  own.remove();
});

const nowS = () => page.evaluate(() => window.__twin.lastTick * 0.01);

const phase = () => page.evaluate(() => window.__twin.state.phase);

const seek = async (timeS) => {
  await page.fill("#at", String(timeS));
  await page.press("#at", "Enter");
  await until(async () => Math.abs((await nowS()) - timeS) <= TICK_S, 20_000, `the console shows ${timeS} s`);
};

test("it says that it is a recording, and shows how far twin and vehicle part, not a controller", async () => {
  assert.match(await page.textContent("#mirror-bar"), /mirrored.*hover\.mcap/s);
  const titles = (await page.evaluate(() => window.__twin.charts.panels.map(({ title }) => title)));
  assert.ok(titles.includes("Divergence from the twin"), titles.join(", "));
  assert.ok(!titles.includes("Robust term"), titles.join(", "));
  assert.equal(await page.isVisible("#wind-open"), false);
});

test("a seek shows that moment, with the seconds before it on the charts", async () => {
  await seek(8);
  assert.ok((await page.evaluate(() => window.__twin.rows)) >= 800, "the run-up is in the history, without a hole");
  assert.equal(await page.evaluate(() => window.__twin.gapTicks), 0);
  await page.keyboard.press("Control+ArrowLeft");
  await until(async () => Math.abs((await nowS()) - 7.99) < TICK_S / 2, 20_000, "one tick back");
});

test("back and forward again, the charts keep what they had drawn before the run-up", async () => {
  await seek(11);
  const x = () => page.evaluate(() => Array.from({ length: 1101 }, (_, tick) => window.__twin.at("chi.x", tick)));
  // The run-up of the seek to 11 s begins at 1 s. The rows before it came with the seek to 8 s, so no tick is unknown.
  const known = (values, to) => values.slice(0, to).every((value) => value !== null);
  const before = await x();
  assert.ok(known(before, 1100), `unknown at ${before.indexOf(null)}`);
  for (const timeS of [3, 10.5]) {
    await seek(timeS);
    const now = await x();
    assert.ok(known(now, timeS * 100), `unknown at ${now.indexOf(null)} after the way to ${timeS} s`);
    // Measured values do not depend on the seeks before them.
    assert.deepEqual(now.slice(0, timeS * 100), before.slice(0, timeS * 100));
    assert.deepEqual(await page.evaluate(() => window.__twin.charts.gaps), []);
    const error = await until(async () => {
      const panel = (await page.evaluate(() => window.__twin.charts.panels)).find(({ visible, series }) => visible && series.length > 0);
      return panel?.series[0];
    }, 10_000, "a chart is drawn");
    assert.equal(error.breaks, 0);
  }
});

test("a stretch marked on the charts is played again and again", async () => {
  await seek(4);
  // The keys I and O mark the range at the time of playback, so the stretch reaches from 4 s to about 5 s.
  await page.keyboard.press("i");
  await page.click("#play");
  await until(async () => (await nowS()) >= 5, 20_000, "a second is played");
  await page.keyboard.press("o");
  await page.click("#loop");
  await until(async () => (await page.textContent("#loop")) !== "Loop", 20_000, "the button names the stretch");
  const [from, to] = (await page.textContent("#loop")).match(/[\d.]+/g).map(Number);
  assert.ok(from >= 3.9 && from <= 4.2 && to >= 4.9 && to < FLIGHT_S - 1, `${from} to ${to}`);
  const seen = [];
  await until(async () => {
    seen.push(await nowS());
    return seen.filter((time, k) => k > 0 && time < seen[k - 1] - 0.5).length >= 2;
  }, 40_000, () => `it went back twice; seen ${seen.slice(-20).join(", ")}`);
  // The page checks the end of the loop a few times a second, and the seek takes a time that depends on the machine.
  assert.ok(Math.max(...seen) < to + 2, `${Math.max(...seen)} after ${to}`);
  await page.click("#loop");
  await until(async () => (await page.textContent("#loop")) === "Loop", 20_000, "no loop");
});

test("the whole of it is played again from its end when nothing is marked", async () => {
  await page.keyboard.press("Control+k");
  await page.keyboard.type("forget the range");
  await page.keyboard.press("Enter");
  if ((await phase()) === "flying") await page.click("#play");
  await until(async () => (await phase()) === "paused", 20_000, "it is held");
  await seek(FLIGHT_S - 1);
  await page.click("#loop");
  await page.click("#play");
  await until(async () => (await nowS()) < 2, 40_000, "it begins again");
  await pause(300);
  assert.equal(await phase(), "flying");
  await page.click("#play");
  assert.deepEqual(complaints.filter((text) => !/GPU stall|swiftshader/i.test(text)), []);
});

test("there is one set of controls, a click on a chart seeks, and the timeline has the phases of all of it", async () => {
  await page.click("#loop");
  assert.equal(await page.isVisible("#pause"), false, "the controls of a flight that nobody flies");
  await seek(10);
  await page.locator('.chart[data-key="innovation"] .u-over').click({ position: { x: 60, y: 20 } });
  await until(async () => (await nowS()) < 9, 20_000, "an earlier moment");
  const { lanes } = await page.evaluate(() => window.__twin.time);
  assert.deepEqual(lanes.phases, ["in the air: residual known, the twin predicts and adapts in shadow"]);
  assert.ok(Math.abs(lanes.span[1] - FLIGHT_S) < 0.1, `${lanes.span}`);
});

test("on a phone nothing sticks out at the side", async () => {
  await page.setViewportSize({ width: 390, height: 844 });
  await pause(500);
  const { wide, out } = await page.evaluate(() => ({
    wide: document.documentElement.scrollWidth,
    out: [...document.querySelectorAll("button, select, input")].filter((node) => node.getBoundingClientRect().right > innerWidth + 0.5).map((node) => node.id),
  }));
  assert.deepEqual([wide, out], [390, []]);
});
