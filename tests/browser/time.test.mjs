// The playhead of a live flight: the whole page shows one moment, while the flight goes on. The flight is held and stepped, so that no test
// depends on the speed of the machine.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { freePort, launchBrowser, NOISE, openHeld, pause, shown, startTwin, until } from "./harness.mjs";
import { Oracle } from "./oracle.mjs";

/** A hover with a grasped payload of 500 g, which drops at 10 s. */
const SCENARIO = "scenarios/reset_demo.toml";
const DROP_TICK = 1000;
/** Telemetry has poses as f32, which at 10 m is exact to 1e-6 m; drawing may multiply this error by ten. */
const POSE_TOLERANCE_M = 1e-5;
const TICK_S = 0.01;
const GAIN = "slope.z";
const SOON = 40_000;
const LIMIT = { timeout: 240_000 };

let browser;
let twin;
let oracle;
let view;
let page;
/** Pose of the vehicle's root at each tick, as telemetry has it. */
const flown = new Map();

before(async () => {
  browser = await launchBrowser();
  twin = await startTwin(SCENARIO, await freePort());
  oracle = await Oracle.connect(twin.url);
  view = await openHeld(browser, twin.url, send);
  page = view.page;
  for (let tick = 0; tick < 60; tick += 1) await advance(5);
}, LIMIT);

after(async () => {
  oracle?.close();
  await browser?.close();
  await twin?.stop();
});

const send = (message) => oracle.socket.send(JSON.stringify(message));
const time = () => page.evaluate(() => window.__twin.time);
const at = (channel, tick) => page.evaluate(([name, when]) => window.__twin.at(name, when), [channel, tick]);
const base = () => oracle.hello.scene.base_body;

/** Flies `ticks` more, until the page has received them. */
async function advance(ticks) {
  const target = oracle.lastTick + ticks;
  send({ type: "step", ticks });
  await until(() => oracle.lastTick >= target, SOON, () => `tick ${target}, now ${oracle.lastTick}`);
  flown.set(oracle.lastTick, [...oracle.poses.get(base())]);
  await until(async () => (await shown(page)).lastTick >= target, SOON, `the page at tick ${target}`);
}

async function live() {
  await page.keyboard.press("End");
  await until(async () => !(await time()).past, SOON, "live");
}

test("back in the past 3-D view, charts, numbers and texts show the same moment, while the flight goes on", LIMIT, async () => {
  await page.keyboard.press("Shift+ArrowLeft");
  // The page moves in its next frame.
  await until(async () => (await page.evaluate(() => document.body.dataset.when)) === "past", SOON, "an amber frame says that this is the past");
  assert.equal((await time()).past, true);
  const { tick } = await time();
  await advance(50);
  assert.equal((await time()).tick, tick, "the page stands while the flight goes on");
  const known = [...flown.keys()].filter((flownTick) => flownTick < tick).at(-1);
  await page.fill("#at", String((known + 1) * TICK_S));
  await page.press("#at", "Enter");
  await page.locator("#scene").focus();
  const stands = (wanted) => until(async () => (await time()).tick === wanted, SOON, () => `the playhead at tick ${wanted}`);
  await stands(known);
  await page.keyboard.press("Control+ArrowLeft");
  await stands(known - 1);
  await page.keyboard.press("Control+ArrowRight");
  await stands(known);
  await until(async () => (await page.evaluate(() => window.__twin.charts.cursorTick)) === known, SOON, "the charts' cursor");
  const drawn = (await shown(page)).bodies[base()];
  [...drawn.position, ...drawn.quaternion_wxyz].forEach((value, k) => assert.ok(Math.abs(value - flown.get(known)[k]) <= POSE_TOLERANCE_M, `pose[${k}]: ${value}, telemetry ${flown.get(known)[k]}`));
  await until(async () => (await page.locator("#time").innerText()) === `${((known + 1) * TICK_S).toFixed(1)} s`, SOON, "the top bar's time");
  const opening = await at("opening_m", known);
  await until(async () => (await page.locator("#hand-reading").textContent()).startsWith(`open ${(opening * 1000).toFixed(0)} mm`), SOON, "the hand's reading");
  assert.match(await page.locator("#phase").innerText(), /past/);
  const behind = (oracle.lastTick - known) * TICK_S;
  await until(async () => Math.abs(Number((await page.locator("#behind").innerText()).replace("−", "").replace(" s", "")) - behind) <= 0.051, SOON, "how far back");
  await live();
  await until(async () => (await page.evaluate(() => document.body.dataset.when)) === "now", SOON, "the frame is gone");
  await until(async () => (await page.evaluate(() => window.__twin.charts.cursorTick)) === null, SOON, "no cursor");
});

test("gains of a past moment are those that were in force then, and cannot be moved", LIMIT, async () => {
  await live();
  const field = page.locator(`[data-gain="${GAIN}"] input[type=number]`);
  const old = Number(await field.inputValue());
  const changedAt = oracle.lastTick + 1;
  send({ type: "set_gain", name: GAIN, value: old + 0.5 });
  await advance(30);
  await until(async () => Number(await field.inputValue()) === old + 0.5, SOON, "the new value");
  await page.keyboard.press("Shift+ArrowLeft");
  await until(async () => Number(await field.inputValue()) === old, SOON, "the value of then");
  assert.ok((await time()).tick < changedAt);
  assert.equal(await page.evaluate(() => document.querySelector("#desk-lock").disabled), true);
  await live();
  await until(async () => Number(await field.inputValue()) === old + 0.5, SOON, "the value in force");
  await until(async () => !(await page.evaluate(() => document.querySelector("#desk-lock").disabled)), SOON, "it can be moved again");
});

test("a typed time, keys for events and a drag on the timeline move the playhead", LIMIT, async () => {
  await page.fill("#at", "1.5");
  await page.press("#at", "Enter");
  await until(async () => (await time()).tick === 149, SOON, "1.5 s is the end of tick 149");
  await page.fill("#at", "-1");
  await page.press("#at", "Enter");
  await until(async () => (await time()).tick === oracle.lastTick - 100, SOON, "1 s before the newest moment");
  const events = await page.locator("#events li").evaluateAll((items) => items.map(({ title }) => Number(/tick (\d+)/.exec(title)?.[1] ?? NaN)));
  await page.locator("#scene").focus();
  await page.keyboard.press("]");
  await until(async () => events.includes((await time()).tick), SOON, () => `one of the events at ${events}`);
  const box = await page.locator("#lanes").boundingBox();
  const { lanes } = await time();
  await page.mouse.move(box.x + box.width / 4, box.y + 30);
  await page.mouse.down();
  await page.mouse.move(box.x + 62 + (box.width - 72) * (2 / (lanes.span[1] - lanes.span[0])), box.y + 30, { steps: 3 });
  await page.mouse.up();
  await until(async () => Math.abs((await time()).shown_s - 2 - lanes.span[0]) < 0.06, SOON, async () => `2 s after the begin of ${lanes.span}, now ${JSON.stringify(await time())}`);
  await page.mouse.move(5, 300);
  await live();
});

test("the past is played, Space stops it, and the pause of the flight is Shift+Space", LIMIT, async () => {
  await page.fill("#at", "1");
  await page.press("#at", "Enter");
  await page.locator("#scene").focus();
  const { phase } = (await shown(page)).state;
  await page.keyboard.press("Space");
  await until(async () => (await time()).shown_s > 1.3, SOON, "it plays");
  await page.keyboard.press("Space");
  assert.equal((await time()).playing, false);
  assert.equal((await shown(page)).state.phase, phase, "the flight is as it was");
  await page.keyboard.press("Shift+Space");
  await until(async () => (await shown(page)).state.phase === "flying", SOON, "the flight flies");
  await page.keyboard.press("Shift+Space");
  await until(async () => (await shown(page)).state.phase === "paused", SOON, "the flight is held");
  await live();
});

test("the log follows the newest event again after a look at the past, and the top bar says that the payload is gone", LIMIT, async () => {
  await page.setViewportSize({ width: 1600, height: 720 });
  await until(async () => /g$/.test(await page.locator("#payload-now").innerText()), SOON, "the hand holds the payload");
  await page.keyboard.press("Home");
  await until(async () => (await time()).past, SOON, "the past");
  await pause(300);
  await live();
  while (oracle.lastTick < DROP_TICK + 50) await advance(Math.min(500, DROP_TICK + 50 - oracle.lastTick));
  const last = page.locator("#events li").last();
  await until(async () => last.evaluate((item) => {
    const [line, list] = [item.getBoundingClientRect(), item.parentElement.getBoundingClientRect()];
    return line.bottom <= list.bottom + 1 && line.top >= list.top - 1;
  }), SOON, "the newest line is in view");
  await until(async () => (await page.locator("#payload-now").innerText()) === "not held", SOON, "the payload has dropped");
  await page.fill("#at", "9");
  await page.press("#at", "Enter");
  await until(async () => /g$/.test(await page.locator("#payload-now").innerText()), SOON, "a second before, the hand held it");
  await live();
});

test("steps of a slider are one line of the log, at the tick since which the last value is in force", LIMIT, async () => {
  const first = (await page.evaluate((name) => window.__twin.gains[name], GAIN));
  for (let step = 1; step <= 6; step += 1) {
    send({ type: "set_gain", name: GAIN, value: first + step / 10 });
    await advance(8);
  }
  const since = oracle.lastTick - 7;
  await advance(120);
  const lines = page.locator("#events li", { hasText: `(${GAIN})` });
  await until(async () => (await lines.last().innerText()).includes(`-> ${(first + 0.6).toFixed(1)}`), SOON, "the line of the last value");
  assert.match(await lines.last().innerText(), new RegExp(`${first} -> ${(first + 0.6).toFixed(1)}`));
  assert.match(await lines.last().getAttribute("title"), new RegExp(`tick ${since}:`));
});

test("the link counts pictures of the 3-D view, none while nothing changes, and the page complains about nothing", LIMIT, async () => {
  await page.setViewportSize({ width: 1280, height: 720 });
  await pause(2500);
  await page.locator("#link").click();
  const pictures = async () => Number((await page.locator("#link-rows tr", { hasText: "3-D view" }).locator("td").innerText()).split(" ")[0]);
  await until(async () => (await pictures()) === 0, SOON, "a held flight is not drawn again");
  await page.keyboard.press("Escape");
  assert.deepEqual(view.complaints.filter((text) => !NOISE.test(text)), []);
});
