// The console against the real server, in a real browser: node --test (TWIN_BIN and CHROMIUM choose other binaries).
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import path from "node:path";
import { after, before, test } from "node:test";
import { freePort, launchBrowser, openConsole, pause, ROOT, shown, startTwin, until } from "./harness.mjs";
import { Oracle } from "./oracle.mjs";

const SCENARIO = "scenarios/a_300g_slow.toml";
/** Telemetry has poses as f32, which at 10 m is exact to 1e-6 m; drawing may multiply this error by ten. */
const POSE_TOLERANCE_M = 1e-5;
/** Time limit of a wait, ms. It is long enough for a loaded machine and short against a test's own limit. */
const SOON = 8000;
/** Bounds of the measured half speed. On a loaded machine it may lag and catch up, but it stays well below full speed. */
const [SLOWEST_HALF, FASTEST_HALF] = [0.2, 0.75];
const LIMIT = { timeout: 120_000 };

let browser;
let twin;
let oracle;
let view;
let page;

before(async () => {
  browser = await launchBrowser();
  twin = await startTwin(SCENARIO, await freePort());
  oracle = await Oracle.connect(twin.url);
  view = await openConsole(browser, twin.url);
  page = view.page;
}, LIMIT);

after(async () => {
  oracle?.close();
  await browser?.close();
  await twin?.stop();
});

const gainsOf = async () => {
  const { gains } = await (await fetch(`${twin.url}/api/gains`)).json();
  return Object.fromEntries(gains.map(({ name, value }) => [name, value]));
};

async function setPaused(paused) {
  const { state } = await shown(page);
  if ((state.phase === "paused") !== paused) await page.keyboard.press("Space");
  await until(async () => ((await shown(page)).state.phase === "paused") === paused, SOON, `paused is ${paused}`);
}

/** Waits until page and oracle are at the same tick. */
async function inStep(client = oracle, target = page) {
  return until(async () => {
    const now = await shown(target);
    return now.lastTick === client.lastTick && now;
  }, SOON, () => `page at the oracle's tick ${client.lastTick}`);
}

test("the page loads, connects and complains about nothing", LIMIT, async () => {
  await pause(1500);
  const now = await shown(page);
  assert.equal(now.connected, true);
  assert.equal(now.stale, false);
  assert.equal(now.scenario, oracle.hello.scenario);
  assert.deepEqual(view.complaints.filter((text) => !/GPU stall|swiftshader/i.test(text)), []);
});

test("the camera keys choose overview, follow and the close-up of the hand", LIMIT, async () => {
  const pressed = () => page.locator(".scene-tools [aria-pressed=true]").allInnerTexts();
  assert.deepEqual(await pressed(), ["Overview", "Hand"]);
  await page.keyboard.press("v");
  await page.keyboard.press("h");
  assert.deepEqual(await pressed(), ["Follow"]);
  await until(() => page.locator("#hand").isHidden(), SOON, "the close-up is gone");
  await page.keyboard.press("f");
  await page.keyboard.press("h");
  assert.deepEqual(await pressed(), ["Overview", "Hand"]);
  await until(() => page.locator("#hand").isVisible(), SOON, "the close-up is back");
  assert.match(await page.locator("#hand").innerText(), /open \d+ mm · grip \d+\.\d N/);
});

test("the vehicle moves, and is drawn where telemetry says", LIMIT, async () => {
  const base = oracle.hello.scene.base_body;
  const start = (await shown(page)).bodies[base].position;
  const moved = async () => {
    const { position } = (await shown(page)).bodies[base];
    return Math.hypot(...position.map((value, k) => value - start[k])) > 0.05;
  };
  await until(moved, 40_000, `${base} moves by 5 cm`);
  await setPaused(true);
  const now = await inStep();
  assert.ok(oracle.poses.size > 1);
  for (const [name, pose] of oracle.poses) {
    const drawn = [...now.bodies[name].position, ...now.bodies[name].quaternion_wxyz];
    drawn.forEach((value, k) => {
      if (Number.isFinite(pose[k])) assert.ok(Math.abs(value - pose[k]) <= POSE_TOLERANCE_M, `${name}[${k}]: ${value}, telemetry ${pose[k]}`);
    });
  }
  await setPaused(false);
});

test("a slider reaches the server and a second page; Ctrl+Z takes it back", LIMIT, async () => {
  const second = await openConsole(browser, twin.url);
  const name = "slope.z";
  const old = (await gainsOf())[name];
  await page.locator(`[id="gain-${name}"]`).focus();
  await page.keyboard.press("ArrowRight");
  await until(async () => (await gainsOf())[name] > old, SOON, "the server has the new gain");
  const now = (await gainsOf())[name];
  await until(async () => (await shown(page)).gains[name] === now, SOON, "the first page shows it");
  await until(async () => (await shown(second.page)).gains[name] === now, SOON, "the second page shows it");
  const field = second.page.locator(".gain", { has: second.page.locator(`[id="gain-${name}"]`) }).locator("input[type=number]");
  assert.ok(Math.abs(Number(await field.inputValue()) - now) < 1e-6);
  await page.keyboard.press("Control+z");
  await until(async () => (await gainsOf())[name] === old, SOON, "undo reaches the server");
  await second.close();
});

test("an unusable gain is refused with a notice and changes nothing", LIMIT, async () => {
  const name = "damping.z";
  const old = (await gainsOf())[name];
  const field = page.locator(".gain", { has: page.locator(`[id="gain-${name}"]`) }).locator("input[type=number]");
  await field.fill("99999");
  await field.press("Enter");
  const notice = page.locator(".notice", { hasText: name });
  await notice.waitFor({ timeout: SOON });
  assert.match(await notice.innerText(), /refused/);
  assert.equal((await gainsOf())[name], old);
  await until(async () => Math.abs(Number(await field.inputValue()) - old) < 1e-6, SOON, "the field shows the value in force");
  await page.locator("#scene").focus();
});

test("a preset changes every gain that differs, and undo brings them back", LIMIT, async () => {
  const old = await gainsOf();
  await page.locator("#presets button", { hasText: "paper" }).click();
  await until(async () => (await shown(page)).preset === "paper", SOON, "preset paper is in force");
  assert.notDeepEqual(await gainsOf(), old);
  assert.equal(await page.locator(".gain.modified").count(), 0);
  await page.keyboard.press("Control+z");
  await until(async () => JSON.stringify(await gainsOf()) === JSON.stringify(old), SOON, "the old gains are back");
});

test("pause holds the flight, a step is one tick, speed and restart do what they say", LIMIT, async () => {
  await page.locator("#scene").focus();
  await setPaused(true);
  const held = (await inStep()).lastTick;
  await pause(600);
  assert.equal((await shown(page)).lastTick, held);
  await page.keyboard.press("Control+ArrowRight");
  await until(async () => (await shown(page)).lastTick === held + 1, SOON, "one tick later");
  await pause(400);
  assert.equal((await shown(page)).lastTick, held + 1);

  await page.locator("#speed").selectOption("0.5");
  await page.locator("#scene").focus();
  await setPaused(false);
  await until(async () => (await shown(page)).state.speed === 0.5, SOON, "half speed");
  await pause(500);
  const [simulatedS, wallS] = [oracle.simulatedS, oracle.wallS];
  await pause(3000);
  const rate = (oracle.simulatedS - simulatedS) / (oracle.wallS - wallS);
  assert.ok(rate > SLOWEST_HALF && rate < FASTEST_HALF, `half speed runs at ${rate}`);

  await page.locator("#speed").selectOption("1");
  await page.locator("#scene").focus();
  const before = (await shown(page)).lastTick;
  await page.keyboard.press("r");
  await until(async () => (await shown(page)).lastTick < before, SOON, "ticks start anew");
  await until(async () => (await shown(page)).lastTick > 20, SOON, "and go on");
  assert.ok((await shown(page)).rows <= (await shown(page)).lastTick + 1, "the old flight's history is gone");
});

/** Elements that overlap or stick out of the page on a laptop, on a large screen and on a phone. */
async function layoutFaults(page) {
  const all = [];
  for (const [width, height] of [[1280, 720], [1920, 1080], [390, 844]]) {
    await page.setViewportSize({ width, height });
    await pause(400);
    const faults = await page.evaluate(() => {
      const found = [];
      if (document.documentElement.scrollWidth > innerWidth) found.push(`page is ${document.documentElement.scrollWidth} px wide`);
      const boxes = [...document.querySelectorAll(".topbar button, .topbar select, .topbar .reading, .badge:not([hidden]), .scene-tools button, .scene-key, #hand")]
        .map((node) => ({ name: node.id || node.className, ...node.getBoundingClientRect().toJSON() }))
        .filter(({ width }) => width > 0);
      for (const a of boxes) {
        if (a.right > innerWidth + 0.5) found.push(`${a.name} ends at ${a.right}`);
        for (const b of boxes) {
          const overlap = a.left < b.right - 0.5 && b.left < a.right - 0.5 && a.top < b.bottom - 0.5 && b.top < a.bottom - 0.5;
          if (a.name < b.name && overlap) found.push(`${a.name} overlaps ${b.name}`);
        }
      }
      return found;
    });
    all.push(...faults.map((fault) => `${width}x${height}: ${fault}`));
  }
  return all;
}

test("nothing overlaps and nothing sticks out, from desk to phone", LIMIT, async () => {
  assert.deepEqual(await layoutFaults(page), []);
});

test("pictures for people", LIMIT, async () => {
  const out = path.join(ROOT, "out");
  mkdirSync(out, { recursive: true });
  await page.evaluate(() => document.activeElement?.blur());
  for (const colorScheme of ["dark", "light"]) {
    await page.emulateMedia({ colorScheme });
    for (const [width, height] of [[1280, 720], [1920, 1080]]) {
      await page.setViewportSize({ width, height });
      await pause(2500);
      await page.screenshot({ path: path.join(out, `console-${width}x${height}-${colorScheme}.png`) });
    }
  }
  await page.emulateMedia({ colorScheme: "dark" });
  await page.setViewportSize({ width: 1280, height: 720 });
  await pause(1000);
  await page.screenshot({ path: path.join(out, "console.png") });
});

test("a dead server is shown at once, and the page comes back with it", LIMIT, async () => {
  const { port } = twin;
  const before = (await shown(page)).lastTick;
  await twin.stop();
  await until(async () => (await shown(page)).stale, SOON, "the page greys");
  assert.match(await page.locator("#link-banner").innerText(), /No connection/);
  twin = await startTwin(SCENARIO, port);
  await until(async () => {
    const now = await shown(page);
    return now.connected && !now.stale && now.lastTick > 10 && now.lastTick < before;
  }, 20_000, "the page shows the new flight");
  assert.equal(await page.locator("#link-banner").isHidden(), true);
});

test("reset_demo shows as many reset marks as telemetry has, and ends in green", LIMIT, async () => {
  const demo = await startTwin("scenarios/reset_demo.toml", await freePort());
  try {
    const witness = await Oracle.connect(demo.url);
    const other = await openConsole(browser, demo.url);
    await other.page.locator("#speed").selectOption("5");
    await other.page.locator("#scene").focus();
    const before = (await shown(other.page)).lastTick;
    await other.page.keyboard.press("r");
    await until(async () => (await shown(other.page)).lastTick < before, SOON, "the flight starts anew");
    await until(async () => (await shown(other.page)).resets > 0, 60_000, "a reset mark");
    await other.page.keyboard.press("Space");
    await until(async () => (await shown(other.page)).state.phase !== "flying", SOON, "the flight is held");
    const now = await inStep(witness, other.page);
    if (now.gapTicks === 0 && witness.gapTicks === 0) assert.equal(now.resets, witness.resets);
    await other.page.locator('#events [data-tone="warn"]', { hasText: "reset" }).first().waitFor({ timeout: SOON });
    await pause(500);
    await other.page.screenshot({ path: path.join(ROOT, "out", "console-reset.png") });
    await other.page.keyboard.press("Space");
    await until(async () => (await shown(other.page)).state.phase === "ended", 60_000, "the flight ends");
    const verdict = other.page.locator("#verdict");
    assert.match(await verdict.innerText(), /✓ completed/);
    assert.equal(await verdict.getAttribute("data-tone"), "good");
    witness.close();
    assert.deepEqual(await layoutFaults(other.page), [], "with the verdict beside the phase");

    // A page that connects after the end sees the whole flight: every tick, every mark, and the last pose of the vehicle.
    const ended = await shown(other.page);
    const late = await openConsole(browser, demo.url);
    const seen = await until(async () => {
      const shows = await shown(late.page);
      return shows.lastTick === ended.lastTick && shows;
    }, SOON, "the late page is at the last tick");
    assert.deepEqual({ rows: seen.rows, gapTicks: seen.gapTicks }, { rows: ended.lastTick + 1, gapTicks: 0 });
    assert.ok(seen.resets >= ended.resets && seen.resets > 0);
    await until(async () => (await shown(late.page)).bodies.base_link?.position[2] > 0.1, SOON, "the vehicle is drawn in the air");
    await late.close();
  } finally {
    await demo.stop();
  }
});
