// The page of `twin export html` and the replay of a failed test: one file without a network, which opens at the time of the failure.
import assert from "node:assert/strict";
import { pathToFileURL } from "node:url";
import { after, before, test } from "node:test";
import { launchBrowser, openPage, runTwin, scratch, until } from "./harness.mjs";

const own = scratch("replay");
let browser;
let page;
let complaints;
let asked;

before(async () => {
  // A controller without feedback on z must keep a bound that it cannot keep, so the test fails and writes its replay.
  const flags = ["test", "scenarios/fails_broken_controller.toml", "--set", "expect.fails=tilt_rad", "--artifacts", own.folder, "--json"];
  const [failed] = JSON.parse(runTwin(flags, [1])).cases;
  assert.match(failed.message, /position_error_m/);
  browser = await launchBrowser();
  const url = pathToFileURL(own.file("fails_broken_controller.html")).href;
  const shows = () => (window.__replay?.shownPose.length ?? 0) === 3;
  const look = { viewport: { width: 1440, height: 900 }, colorScheme: "dark", offline: true };
  ({ page, complaints, asked } = await openPage(browser, url, shows, { ...look, kinds: ["error", "warning"], withinMs: 20_000 }));
});

after(async () => {
  await browser?.close();
  own.remove();
});

const replay = () => page.evaluate(() => ({ ...window.__replay }));

test("it opens at the second at which the bound broke, and says which", async () => {
  const text = await page.textContent("#failures");
  const broken = Number(/broken at ([\d.]+) s/.exec(text)[1]);
  const { time, failures } = await replay();
  assert.ok(Math.abs(time - broken) < 0.011, `${time} against ${broken}: one tick`);
  assert.equal(failures, 1);
  assert.match(text, /position_error_m/);
  assert.equal(await page.getAttribute("#verdict", "data-tone"), "bad");
});

test("it needs nothing but itself, and the browser has nothing to complain about", () => {
  assert.deepEqual(asked.filter((url) => !/^(file|data|blob):/.test(url)), []);
  assert.deepEqual(complaints.filter((text) => !/GPU stall|swiftshader/i.test(text)), []);
});

test("it says that a demand was not met, and shows the signal with its limit before all other charts", async () => {
  assert.equal(await page.textContent("#verdict"), "✕ 1 demand not met");
  const [first] = (await replay()).charts;
  assert.match(first.title, /^Not kept: position error/);
  const [found, allowed] = first.series;
  assert.equal(allowed.value, Math.fround(0.15));
  // It opens at the tick at which the error first exceeds the limit.
  assert.ok(found.value > allowed.value && found.value < allowed.value + 0.01, `${found.value}`);
});

test("a typed time and a drag on the timeline move the vehicle and the clock of the charts together", async () => {
  const type = async (time) => {
    await page.fill("#at", String(time));
    await page.press("#at", "Enter");
  };
  const heights = [];
  for (const time of [10, 11.9, 1]) {
    await type(time);
    await until(async () => Math.abs((await replay()).time - time) < 0.006 && (await page.textContent("#time")) === `${time.toFixed(2)} s`, 5_000, `the clock shows ${time} s`);
    heights.push((await replay()).shownPose[2]);
  }
  // Without feedback the vehicle leaves its height by more than the bound of 15 cm, the farther the later; only the air damps it.
  const [late, last, early] = heights;
  assert.ok(Math.abs(last - early) > 0.15 && Math.abs(late - early) > 0.1 && Math.abs(last - late) > 0.03, heights.join());
  const box = await page.locator("#lanes").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + 20);
  await page.mouse.down();
  await page.mouse.up();
  await until(async () => Math.abs((await replay()).time - 6.2) < 0.5, 5_000, "the middle of the timeline is the middle of the flight");
});

test("its timeline is inside every window, and nothing sticks out on a phone", async () => {
  for (const [width, height] of [[1280, 720], [1920, 1080], [390, 844], [1440, 900]]) {
    await page.setViewportSize({ width, height });
    await until(async () => {
      const box = await page.locator("#lanes").boundingBox();
      return box !== null && box.height > 40 && box.y + box.height <= height && box.x >= 0 && box.x + box.width <= width;
    }, 5_000, `the timeline in ${width}x${height}`);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    const scene = await page.locator("#scene").boundingBox();
    assert.ok(scene.width >= Math.min(width, 500) - 1 && scene.height > 150, `${width}x${height}: the 3-D view has ${scene.width} x ${scene.height}`);
  }
});

test("a click on a chart seeks, also while it plays", async () => {
  await page.keyboard.press("Space");
  const over = page.locator('.chart[data-key="residual"] .u-over');
  const { width } = await over.boundingBox();
  await over.click({ position: { x: width * 0.45, y: 30 } });
  const { time } = await replay();
  assert.ok((await replay()).playing && time > 8.5 && time < 9.8, `${time} s at 45 % of 20 s`);
  await until(async () => (await replay()).time > time + 0.2, 10_000, "it plays on from there");
  await page.keyboard.press("Space");
});

test("the eigenvalues of the covariance are known, and a replay shows them as bars", async () => {
  const charts = (await replay()).charts;
  const covariance = charts.find(({ key }) => key === "covariance");
  const values = Object.fromEntries(covariance.series.map(({ channel, value }) => [channel, value]));
  assert.ok(values.covariance_eig_max > 0 && values.covariance_eig_max <= values.covariance_trace, JSON.stringify(values));
  const bars = charts.find(({ key }) => key === "spectrum").series.map(({ value }) => value);
  assert.ok(bars.length > 1 && bars.every((value, k) => k === 0 || value <= bars[k - 1]));
  const sum = bars.reduce((all, value) => all + value, 0);
  // The eigenvalues are newer by at most ten ticks than the trace of this tick, or older.
  assert.ok(Math.abs(sum - values.covariance_trace) < 0.2 * sum, `${sum} against the trace ${values.covariance_trace}`);
});

test("it plays, stops, and goes back to the failure", async () => {
  await page.keyboard.press("Space");
  const { time } = await replay();
  await until(async () => (await replay()).time > time + 0.3, 10_000, "time goes on");
  await page.keyboard.press("Space");
  assert.equal((await replay()).playing, false);
  await page.click("#failures button");
  const broken = Number(/broken at ([\d.]+) s/.exec(await page.textContent("#failures"))[1]);
  await until(async () => Math.abs((await replay()).time - broken) < 0.011, 5_000, "it is back at the failure");
  if (process.env.TWIN_SHOT) await page.screenshot({ path: process.env.TWIN_SHOT });
});
