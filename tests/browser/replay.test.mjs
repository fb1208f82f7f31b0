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

test("scrubbing moves the vehicle and the clock of the charts together", async () => {
  const scrub = (time) =>
    page.$eval("#scrub", (input, value) => {
      input.value = String(value);
      input.dispatchEvent(new Event("input"));
    }, time);
  const heights = [];
  for (const time of [10, 11.9, 1]) {
    await scrub(time);
    await until(async () => Math.abs((await replay()).time - time) < 0.006 && (await page.textContent("#time")) === `${time.toFixed(2)} s`, 5_000, `the clock shows ${time} s`);
    heights.push((await replay()).shownPose[2]);
  }
  // Without feedback the vehicle leaves its height by more than the bound of 15 cm, the farther the later; only the air damps it.
  const [late, last, early] = heights;
  assert.ok(Math.abs(last - early) > 0.15 && Math.abs(late - early) > 0.1 && Math.abs(last - late) > 0.03, heights.join());
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
