// The fan of forecasts and the lead, as drawn: pixels of the screen are compared with the times that telemetry says.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { freePort, launchBrowser, NOISE, openHeld, pause, startTwin, until } from "./harness.mjs";
import { Oracle } from "./oracle.mjs";

const SOON = 40_000;
const LIMIT = { timeout: 240_000 };
const TICK_S = 0.01;
/** Room of the value axis at the left of a plot and of the margin at its right, px. */
const [LEFT_PX, RIGHT_PX] = [46, 14];
/** The close-up shows this much before and after now, s. */
const [PAST_S, AHEAD_S] = [0.75, 0.25];
/** Length of the shortest stretch that the list offers, s. */
const WINDOW_S = 2;
/** A vertical line, dashed half and half, covers at least this part of the height. */
const LINE_SHARE = 0.3;
/** Sum over the three channels up to which a pixel has the colour of a line. */
const SAME_COLOR = 60;

let browser;
let twin;
let oracle;
let view;
let page;

before(async () => {
  browser = await launchBrowser();
  const flags = ["--set", "predictor.kind=fdt", "--set", "gains.preset=tuned"];
  twin = await startTwin("scenarios/hover.toml", await freePort(), flags);
  oracle = await Oracle.connect(twin.url);
  view = await openHeld(browser, twin.url, send);
  page = view.page;
  await page.locator("#window").selectOption(String(WINDOW_S));
  send({ type: "step", ticks: 300 });
}, LIMIT);

after(async () => {
  oracle?.close();
  await browser?.close();
  await twin?.stop();
});

const send = (message) => oracle.socket.send(JSON.stringify(message));

/** Looks ahead by `share` of the loop's delay; flies on until the page has drawn it. Returns the lead in s. */
async function leadOf(share) {
  await pause(500);
  const target = oracle.lastTick + 100;
  send({ type: "set_gain", name: "lead.z", value: share });
  send({ type: "step", ticks: 100 });
  await until(async () => oracle.lastTick >= target && (await page.evaluate(() => window.__twin.lastTick)) >= target, SOON, `tick ${target}`);
  await pause(1000);
  return oracle.channels.get("lead_s.z");
}

/** For each column of pixels of a plot, the part of its height with the colour of the forecast, and with a tint of it. */
async function columns(key) {
  const png = (await page.locator(`.chart[data-key="${key}"] .plot`).screenshot()).toString("base64");
  return page.evaluate(async ([data, same]) => {
    const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const pen = new OffscreenCanvas(image.width, image.height).getContext("2d");
    pen.drawImage(image, 0, 0);
    const { data: pixels } = pen.getImageData(0, 0, image.width, image.height);
    const token = getComputedStyle(document.documentElement).getPropertyValue("--fourth").trim();
    const color = [1, 3, 5].map((at) => parseInt(token.slice(at, at + 2), 16));
    const pixel = (x, y) => [0, 1, 2].map((k) => pixels[4 * (y * image.width + x) + k]);
    const near = (rgb) => rgb.reduce((sum, value, k) => sum + Math.abs(value - color[k]), 0) <= same;
    // The colour of the forecast has more red than green; neither background nor grid has.
    const tinted = ([red, green]) => red - green > 10;
    const share = (x, test) => Array.from({ length: image.height }, (_, y) => test(pixel(x, y))).filter(Boolean).length / image.height;
    return Array.from({ length: image.width }, (_, x) => ({ line: share(x, near), tint: share(x, tinted) }));
  }, [png, SAME_COLOR]);
}

/** Whether a vertical line stands within a pixel of `x`. */
const lineAt = (found, x) => [-1, 0, 1].some((off) => (found[Math.round(x) + off]?.line ?? 0) >= LINE_SHARE);

test("telemetry has the forecast, and its error is what came less what was foretold", LIMIT, async () => {
  const lead = await leadOf(1);
  const tick = oracle.lastTick;
  const ticks = Math.round(lead / TICK_S);
  const at = (channel, when) => page.evaluate(([name, at]) => window.__twin.at(name, at), [channel, when]);
  const [error, measured, foretold] = [await at("foresight_error.z", tick), await at("residual.z", tick), await at("foreseen.z", tick - ticks)];
  assert.ok(Math.abs(error - (measured - foretold)) < 1e-4, `${error}, by hand ${measured - foretold}`);
  assert.ok(Math.abs((await at("foretold.z", tick)) - foretold) < 1e-4);
});

test("the close-up has a line at now and one at the lead, and the fan reaches to the horizon", LIMIT, async () => {
  for (const share of [1, 0.5]) {
    const lead = await leadOf(share);
    const found = await columns("foresight");
    const width = found.length - LEFT_PX - RIGHT_PX;
    const x = (ahead) => LEFT_PX + ((PAST_S + ahead) / (PAST_S + AHEAD_S)) * width;
    assert.ok(lineAt(found, x(0)), "now");
    assert.ok(lineAt(found, x(lead)), `the lead of ${lead} s`);
    const others = found.slice(Math.ceil(x(0)) + 3).filter((_, k) => Math.abs(k + Math.ceil(x(0)) + 3 - x(lead)) > 2);
    assert.ok(others.every(({ line }) => line < LINE_SHARE), "no other line");
    for (let ahead = 0.02; ahead < AHEAD_S - 0.01; ahead += 0.02) assert.ok(found[Math.round(x(ahead))].tint > 0, `the fan at ${ahead} s`);
  }
});

test("on the residual the fan and the lead stand ahead of now on the shared clock", LIMIT, async () => {
  const lead = await leadOf(1);
  const { span } = await page.evaluate(() => window.__twin.charts);
  const now = (oracle.lastTick + 1) * TICK_S;
  const found = await columns("residual");
  const x = (time) => LEFT_PX + ((time - span[0]) / (span[1] - span[0])) * (found.length - LEFT_PX - RIGHT_PX);
  assert.ok(Math.abs(span[1] - span[0] - WINDOW_S) < 1e-9 && span[1] >= now + AHEAD_S - 1e-9, "there is room for the fan");
  assert.ok(lineAt(found, x(now)), "now");
  assert.ok(lineAt(found, x(now + lead)), `the lead of ${lead} s`);
  for (let ahead = 0.02; ahead < AHEAD_S - 0.02; ahead += 0.02) assert.ok(found[Math.round(x(now + ahead))].tint > 0, `the fan at ${ahead} s`);
});

test("without a lead there is no line, and each share of the delay says its lead", LIMIT, async () => {
  const note = page.locator('[data-gain="lead.z"] .unit span').first();
  const lead = await leadOf(1);
  await until(async () => (await note.innerText()) === `${Math.round(lead * 1000)} ms`, SOON, "the lead beside its gain");
  assert.equal(await leadOf(0), 0);
  await until(async () => (await note.innerText()) === "0 ms", SOON, "no lead");
  const found = await columns("foresight");
  const from = Math.ceil(LEFT_PX + PAST_S * (found.length - LEFT_PX - RIGHT_PX)) + 3;
  assert.ok(found.slice(from).every(({ line }) => line < LINE_SHARE), "no line ahead of now");
});

test("the page complains about nothing", LIMIT, () => {
  assert.deepEqual(view.complaints.filter((text) => !NOISE.test(text)), []);
});
