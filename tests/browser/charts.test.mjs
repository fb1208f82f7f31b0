// The charts of the console against the real server, in a real browser. The flight is paused and stepped, so that no test depends
// on the speed of the machine.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import path from "node:path";
import { after, before, test } from "node:test";
import { freePort, launchBrowser, openHeld, pause, ROOT, startTwin, until } from "./harness.mjs";
import { Oracle } from "./oracle.mjs";

/** A hover with a grasped payload of 500 g. The payload drops at 10 s, and with the paper's gains the covariance is reset then. */
const SCENARIO = "scenarios/reset_demo.toml";
const DROP_TICK = 1000;
/** Time limit of a wait, long enough for a loaded machine, ms. */
const SOON = 40_000;
const LIMIT = { timeout: 240_000 };
/** Time of one pixel on a plot of about 400 px with a window of 20 s, s. */
const PIXEL_S = 0.06;
/** Relative tolerance, because telemetry has values as 32-bit floats. */
const FLOAT_SHARE = 1e-6;

let browser;
let twin;
let oracle;
let view;
let page;

before(async () => {
  browser = await launchBrowser();
  twin = await startTwin(SCENARIO, await freePort());
  oracle = await Oracle.connect(twin.url);
  view = await openHeld(await losing(), twin.url, send);
  page = view.page;
  await advance(100);
}, LIMIT);

after(async () => {
  oracle?.close();
  await browser?.close();
  await twin?.stop();
});

const send = (message) => oracle.socket.send(JSON.stringify(message));
const charts = (on = page) => on.evaluate(() => window.__twin.charts);
const lastTick = (on = page) => on.evaluate(() => window.__twin.lastTick);
/** The value of a channel as the charts draw it: without the known weight. */
const drawnAt = async (channel, tick) => (await at(channel, tick)) - (oracle.hello.channels.find(({ name }) => name === channel).weight ?? 0);
const at = (channel, tick, on = page) => on.evaluate(([name, when]) => window.__twin.at(name, when), [channel, tick]);
const panel = async (key) => (await charts()).panels.find((candidate) => candidate.key === key);
const over = (key) => page.locator(`.chart[data-key="${key}"] .u-over`);

/** A browser whose page can lose frames: while `window.__lose` is set, telemetry is dropped before the page sees it. */
async function losing() {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, colorScheme: "dark", acceptDownloads: true });
  await context.addInitScript(() => {
    const Original = window.Worker;
    window.Worker = class extends Original {
      set onmessage(listener) {
        super.onmessage = (event) => (window.__lose && event.data.kind === "binary" ? undefined : listener.call(this, event));
      }
    };
  });
  return { newContext: async () => context };
}

/** Flies `ticks` more and waits until the page has received them. */
async function advance(ticks) {
  const target = (await settled()) + ticks;
  for (let left = ticks; left > 0; left -= 500) {
    send({ type: "step", ticks: Math.min(500, left) });
    await until(() => oracle.lastTick >= target - Math.max(0, left - 500), SOON, () => `tick ${target}, now ${oracle.lastTick}`);
  }
  await until(async () => (await lastTick()) >= target, SOON, `the page at tick ${target}`);
  return target;
}

/** The newest tick after all steps are flown. */
async function settled() {
  for (;;) {
    const before = oracle.lastTick;
    await pause(400);
    if (oracle.lastTick === before) return before;
  }
}

/** Waits until the charts have drawn the newest data. */
async function drawn() {
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  await until(async () => {
    const { panels } = await charts();
    return panels.filter(({ visible }) => visible).length > 0;
  }, SOON, "charts in view");
  await pause(300);
}

async function live() {
  await page.keyboard.press("Escape");
  await page.keyboard.press("Escape");
  await until(async () => !(await charts()).inspecting, SOON, "the charts follow the flight");
}

test("the most important charts come first and read what telemetry says", LIMIT, async () => {
  const { panels } = await charts();
  assert.deepEqual(panels.slice(0, 5).map(({ key }) => key), ["residual", "foresight", "innovation", "covariance", "tracking"]);
  const tick = await settled();
  await until(async () => (await panel("residual")).series[0].value === (await drawnAt("residual.z", tick)), SOON, "the newest residual");
  assert.equal(await panel("spectrum"), undefined, "the covariance of this adapter is one number: no bars");
});

test("residuals as z-scores are residuals over the scale of the channel", LIMIT, async () => {
  const tick = await settled();
  const scale = oracle.hello.channels.find(({ name }) => name === "residual.z").z_scale;
  const physical = await drawnAt("residual.z", tick);
  await page.locator('.chart[data-key="residual"] button', { hasText: "z-score" }).click();
  await until(async () => (await charts()).zscore, SOON, "z-scores");
  const near = async () => Math.abs((await panel("residual")).series[0].value - physical / scale) <= FLOAT_SHARE * Math.abs(physical);
  await until(near, SOON, `${physical} N over ${scale}`);
  await page.locator('.chart[data-key="residual"] button', { hasText: "z-score" }).click();
  await until(async () => (await panel("residual")).series[0].value === physical, SOON, "newtons again");
});

test("the errors of all coordinates are shown at once in z-scores, and a click on one chooses it", LIMIT, async () => {
  const tick = await settled();
  const shown = page.locator('.chart[data-key="multiples"]');
  await shown.scrollIntoViewIfNeeded();
  const errors = () => panel("multiples").then(({ series }) => series);
  await until(async () => (await errors()).length === 16, SOON, "two lines for each of eight coordinates");
  const scale = oracle.hello.channels.find(({ name }) => name === "residual.y").z_scale;
  const wanted = ((await at("residual.y", tick)) - (await at("base.y", tick))) / scale;
  const found = (await errors()).find(({ channel }) => channel === "error of base.y").value;
  assert.ok(Math.abs(found - wanted) <= FLOAT_SHARE * Math.max(1, Math.abs(wanted)), `${found}, by hand ${wanted}`);
  const { width, height } = await shown.locator("canvas").boundingBox();
  // The second field of the upper line, whose four fields stand beside the axis.
  await shown.locator("canvas").click({ position: { x: 46 + ((width - 60) * 3) / 8, y: height / 4 } });
  await until(async () => (await panel("residual")).series[0].channel === "residual.y", SOON, "the charts of y");
  await page.locator('#rows button[value="z"]').click();
  await until(async () => (await panel("residual")).series[0].channel === "residual.z", SOON, "the charts of z");
  await page.locator("#charts").evaluate((list) => list.scrollTo(0, 0));
});

test("the cursor of one chart reads the same moment on all, as the history holds it", LIMIT, async () => {
  await advance(300);
  await over("innovation").hover({ position: { x: 50, y: 20 } });
  await until(async () => (await charts()).cursorTick !== null, SOON, "a cursor");
  await drawn();
  const { cursorTick, panels } = await charts();
  assert.ok(cursorTick >= 0 && cursorTick < (await lastTick()));
  for (const { key, series } of panels.filter(({ key, visible }) => visible && !["spectrum", "foresight", "multiples"].includes(key))) {
    for (const { channel, value } of series.filter(({ channel }) => !/^(foresight_std|foretold)\./.test(channel))) {
      assert.equal(value, await drawnAt(channel, cursorTick), `${key} ${channel}`);
    }
  }
  const text = await page.locator('.chart[data-key="innovation"] output').first().innerText();
  const exact = await at("innovation_mean", cursorTick);
  assert.ok(Math.abs(Number(text.replace("−", "-")) - exact) <= 0.0006 * Math.max(1, Math.abs(exact)), `${text} is ${exact}`);
  await page.mouse.move(5, 400);
});

test("a step of the payload's mass makes the plotted innovation peak", LIMIT, async () => {
  const before = await advance(100);
  const quiet = await at("innovation_mean", before);
  send({ type: "disturb", disturbance: { kind: "payload_mass", kg: 0.9 } });
  const end = await advance(150);
  let peak = 0;
  for (let tick = before; tick <= end; tick += 1) peak = Math.max(peak, await at("innovation_mean", tick));
  assert.ok(peak > 3 * quiet, `from ${quiet} to ${peak}`);
  await until(async () => Math.abs((await panel("innovation")).series[0].plotted[1] - peak) <= FLOAT_SHARE * peak, SOON, "the peak is drawn");
  assert.ok((await charts()).marks.some(({ kind }) => kind === "disturbance"), "the step is marked");
});

test("a drag zooms all charts to what was dragged over, a double click takes it back", LIMIT, async () => {
  const { span } = await charts();
  const box = await over("covariance").boundingBox();
  const time = (x) => span[0] + ((x - box.x) / box.width) * (span[1] - span[0]);
  const [a, b] = [box.x + 60, box.x + 160];
  await page.mouse.move(a, box.y + 20);
  await page.mouse.down();
  await page.mouse.move((a + b) / 2, box.y + 24);
  await page.mouse.move(b, box.y + 24);
  await page.mouse.up();
  await until(async () => (await charts()).zoomed, SOON, "a zoom");
  await drawn();
  const zoomed = (await charts()).span;
  assert.ok(Math.abs(zoomed[0] - time(a)) <= PIXEL_S && Math.abs(zoomed[1] - time(b)) <= PIXEL_S, `${zoomed} for ${time(a)} to ${time(b)}`);
  await over("residual").dblclick({ position: { x: 200, y: 20 } });
  await until(async () => !(await charts()).inspecting, SOON, "live again");
});

test("inspecting holds the window while the flight and its history go on", LIMIT, async () => {
  await page.mouse.move(5, 400);
  await page.keyboard.press("p");
  await until(async () => (await charts()).inspecting, SOON, "inspecting");
  await drawn();
  const held = (await charts()).span;
  const newest = await advance(150);
  assert.deepEqual((await charts()).span, held);
  assert.notEqual(await at("residual.z", newest), null, "the history goes on");
  await until(async () => (await page.locator("#behind").innerText()) === "−1.5 s", SOON, "the timeline says how far back this is");

  const start = (await charts()).cursorTick;
  await page.keyboard.press("ArrowLeft");
  assert.equal((await charts()).cursorTick, start - 10);
  await page.keyboard.press("Control+ArrowLeft");
  assert.equal((await charts()).cursorTick, start - 11);
  await page.keyboard.press("Control+ArrowRight");
  assert.equal((await charts()).cursorTick, start - 10);
  assert.equal(await settled(), newest, "Ctrl+→ moved the cursor, not the flight");
  await page.keyboard.press("Home");
  const { cursorTick: oldest } = await charts();
  assert.notEqual(await at("residual.z", oldest), null);
  assert.equal(await at("residual.z", oldest - 1), null, "nothing older is held");
  await page.keyboard.press("End");
  assert.equal((await charts()).inspecting, false, "the newest moment is that of the flight");

  await page.keyboard.press("ArrowLeft");
  await page.locator("#to-live").click();
  await until(async () => !(await charts()).inspecting, SOON, "one press back to live");
  await drawn();
  const { span } = await charts();
  assert.ok(span[0] <= newest * 0.01 && newest * 0.01 <= span[1] + PIXEL_S);
});

test("the statistics between I and O are those of the history", LIMIT, async () => {
  await page.keyboard.press("p");
  await page.keyboard.press("o");
  const to = (await charts()).cursorTick;
  for (let k = 0; k < 5; k += 1) await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("i");
  await page.keyboard.press("m");
  await until(async () => (await charts()).range.length > 0, SOON, "a table of statistics");
  await drawn();
  const { cursorTick: from, range, marks } = await charts();
  assert.equal(from, to - 50);
  assert.ok(marks.some(({ kind, tick }) => kind === "marker" && tick === from), "a mark at the cursor");
  const values = [];
  for (let tick = from; tick <= to; tick += 1) values.push(await at("residual.z", tick));
  const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
  const rms = Math.sqrt(values.reduce((sum, value) => sum + value * value, 0) / values.length);
  const row = range.find(({ channel }) => channel === "residual.z");
  for (const [name, value] of Object.entries({ min: Math.min(...values), max: Math.max(...values), mean, rms })) {
    assert.ok(Math.abs(row[name] - value) <= 1e-9 * Math.abs(value), `${name}: ${row[name]}, by hand ${value}`);
  }
  await page.locator("#range-table header button").click();
  await until(() => page.locator("#range-table").isHidden(), SOON, "the table is gone");
  await live();
});

test("a chart of one's own: searched, chosen by keys, remembered, and gone with the default", LIMIT, async () => {
  await page.locator("#charts-menu").click();
  await page.locator("#charts-options button", { hasText: "New chart" }).click();
  const search = page.locator('#picker input[type="search"]');
  const before = await lastTick();
  await search.pressSequentially("rotor thrust r");
  await search.fill("rotor");
  assert.equal(await page.locator("#picker-list li").count(), 4);
  await search.press("Enter");
  await search.press("ArrowDown");
  await search.press("Enter");
  assert.equal(await page.locator('#picker-list li[aria-selected="true"]').count(), 2);
  await search.press("Escape");
  await until(() => page.locator("#picker").isHidden(), SOON, "the picker is closed");
  assert.equal(await lastTick(), before, "letters typed into the search are no keys of the console");
  const own = async () => (await charts()).panels.find(({ key }) => key === "own-1")?.series.map(({ channel }) => channel);
  assert.deepEqual(await own(), ["rotor.0", "rotor.1"]);

  await page.reload();
  await until(() => page.evaluate(() => window.__twin !== undefined), SOON, "the page is back");
  await until(async () => {
    send({ type: "step", ticks: 1 });
    await pause(300);
    return (await lastTick()) >= 0;
  }, SOON, "the page shows the flight");
  assert.deepEqual(await own(), ["rotor.0", "rotor.1"]);
  await page.locator("#charts-menu").click();
  await page.locator("#charts-options button", { hasText: "Reset to default" }).click();
  assert.equal(await own(), undefined);
  await page.keyboard.press("Escape");
});

test("lost ticks are a gap: a break in every line, with a mark that says how many", LIMIT, async () => {
  await settled();
  const first = (await lastTick()) + 1;
  await page.evaluate(() => (window.__lose = true));
  send({ type: "step", ticks: 30 });
  await until(() => oracle.lastTick >= first + 29, SOON, "thirty ticks flown");
  await pause(1000);
  await page.evaluate(() => (window.__lose = false));
  await advance(20);
  await until(async () => (await charts()).marks.some(({ kind }) => kind === "gap"), SOON, "a mark");
  await drawn();
  const { gaps, marks } = await charts();
  assert.deepEqual(gaps, [{ from: first, to: first + 29 }]);
  assert.match(marks.find(({ kind }) => kind === "gap").text, /^30 ticks were lost/);
  assert.equal(await at("residual.z", first), null);
  for (const key of ["residual", "innovation"]) {
    assert.ok((await panel(key)).series[0].breaks > 0, `the first line of ${key} is broken`);
  }
});

test("resets are marked where telemetry has them, and an event shows its moment", LIMIT, async () => {
  let now = await settled();
  if (now < DROP_TICK + 150) now = await advance(DROP_TICK + 150 - now);
  await until(async () => (await charts()).marks.some(({ kind }) => kind === "reset"), SOON, "a reset mark");
  const { marks } = await charts();
  for (const { kind, tick } of marks) if (kind === "reset") assert.equal(await at("reset", tick), 1);
  mkdirSync(path.join(ROOT, "out"), { recursive: true });
  await page.screenshot({ path: path.join(ROOT, "out", "charts-reset.png") });

  const line = page.locator("#events li", { hasText: "reset" }).last();
  const tick = Number(/tick (\d+)/.exec(await line.getAttribute("title"))[1]);
  await line.locator("button").click();
  await until(async () => (await charts()).inspecting, SOON, "inspecting");
  await drawn();
  const { span, cursorTick } = await charts();
  assert.equal(cursorTick, tick);
  assert.ok(span[0] < tick * 0.01 && tick * 0.01 < span[1]);
  assert.equal(await line.getAttribute("aria-current"), "time");
  await live();
});

test("what is seen can be saved: every tick of every channel shown, and a picture", LIMIT, async () => {
  const save = async (kind) => {
    if (await page.locator("#charts-options").isHidden()) await page.locator("#charts-menu").click();
    await page.locator(`#save-${kind}`).click();
  };
  await page.keyboard.press("p");
  await drawn();
  const [csv] = await Promise.all([page.waitForEvent("download"), save("csv")]);
  const lines = readFileSync(await csv.path(), "utf8").trim().split("\r\n").map((line) => line.split(","));
  const [head, ...rows] = lines;
  assert.deepEqual(head.slice(0, 3), ["tick", "t_s", "residual.z [N]"]);
  const { gaps } = await charts();
  assert.ok(rows.every(([tick]) => gaps.every(({ from, to }) => tick < from || tick > to)), "no line for a lost tick");
  for (const row of rows.filter((_, k) => k % 97 === 0)) assert.equal(Math.fround(Number(row[2])), await at("residual.z", Number(row[0])));
  const [png] = await Promise.all([page.waitForEvent("download"), save("png")]);
  const bytes = readFileSync(await png.path());
  assert.deepEqual([...bytes.subarray(1, 4)], [...Buffer.from("PNG")]);
  assert.ok(bytes.readUInt32BE(20) > 700, "as high as all charts together");
  await page.keyboard.press("Escape");
  await live();
});

test("nothing sticks out of the charts and the page complains about nothing", LIMIT, async () => {
  for (const [width, height] of [[1280, 720], [1920, 1080], [390, 844]]) {
    await page.setViewportSize({ width, height });
    await pause(500);
    const faults = await page.evaluate(() => {
      const column = document.querySelector(".charts").getBoundingClientRect();
      return [...document.querySelectorAll(".charts-head > *, .story, .chart-head > *")]
        .map((node) => ({ name: node.id || node.textContent, box: node.getBoundingClientRect() }))
        .filter(({ box }) => box.width > 0 && (box.left < column.left - 0.5 || box.right > column.right + 0.5))
        .map(({ name, box }) => `${name} from ${box.left} to ${box.right}`);
    });
    assert.deepEqual(faults, [], `${width}x${height}`);
  }
  assert.deepEqual(view.complaints.filter((text) => !/GPU stall|swiftshader/i.test(text)), []);
});
