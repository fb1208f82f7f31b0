// An operator's actions with gains, world, palette and keyboard against the real server: node --test.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import path from "node:path";
import { after, before, test } from "node:test";
import WebSocket from "ws";
import { BINARY, freePort, launchBrowser, openConsole, openHeld, pause, ROOT, shown, startTwin, until } from "./harness.mjs";

const SCENARIO = "scenarios/a_300g_slow.toml";
/** Time limit of a wait, ms. It is long enough for a loaded machine and short against a test's own limit. */
const SOON = 15_000;
const LIMIT = { timeout: 180_000 };
/** Smallest side of a control that a finger can use, px. */
const FINGER_PX = 40;
/** Tolerance of a wind, whose components the page rounds to a hundredth, m/s. */
const WIND_TOLERANCE_M_S = 0.011;

let browser;
let twin;
let page;
let witness;

/** A second client that keeps the server's messages and shares no code with the page. */
class Witness {
  gains = [];
  events = [];
  state = null;

  static async connect(url) {
    const made = new Witness();
    made.socket = new WebSocket(url.replace("http", "ws") + "/ws");
    made.socket.on("message", (data, binary) => !binary && made.#hear(JSON.parse(data)));
    await until(() => made.state !== null, SOON, "the witness hears the server");
    return made;
  }

  say(message) {
    this.socket.send(JSON.stringify(message));
  }

  #hear(message) {
    if (message.type === "hello") this.state = message.state;
    if (message.type === "state") this.state = message;
    if (message.type === "gain") this.gains.push(message);
    if (message.type === "events") this.events.push(...message.events);
  }
}

before(async () => {
  browser = await launchBrowser();
  twin = await startTwin(SCENARIO, await freePort());
  witness = await Witness.connect(twin.url);
  ({ page } = await openConsole(browser, twin.url));
  // The flight is paused, so that a loaded machine cannot make the data stale, which would lock the controls under test.
  await hold(true);
}, LIMIT);

after(async () => {
  witness?.socket.terminate();
  await browser?.close();
  await twin?.stop();
});

async function hold(paused) {
  witness.say({ type: "pause", paused });
  await until(async () => ((await shown(page)).state.phase === "paused") === paused, SOON, `paused is ${paused}`);
  if (paused) await unlocked();
}

/** Opens a further page. The flight runs while the page loads, because only ticks show that the page works; then it is paused. */
async function openFree(options) {
  const made = await openHeld(browser, twin.url, (message) => witness.say(message), options);
  await until(() => made.page.evaluate(() => !document.querySelector("#desk-lock").disabled), SOON, "its tuning column is free");
  return made;
}

const unlocked = () => until(() => page.evaluate(() => !document.querySelector("#desk-lock").disabled), SOON, "the tuning column is free");
const gainsOf = async () => {
  const { gains } = await (await fetch(`${twin.url}/api/gains`)).json();
  return Object.fromEntries(gains.map(({ name, value, preset_value }) => [name, { value, preset_value }]));
};
const valueOf = async (name) => (await gainsOf())[name].value;
const row = (name) => page.locator(`.gain[data-gain="${name}"]`);
const becomes = (name, value) => until(async () => Math.abs((await valueOf(name)) - value) < 1e-9, SOON, `${name} is ${value} on the server`);
const showsGain = (name, value) => until(async () => Math.abs((await shown(page)).gains[name] - value) < 1e-9, SOON, `the page shows ${name} = ${value}`);
const tab = (name) => page.locator(`#tab-${name}`).click();

async function palette(text) {
  await page.keyboard.press("Control+k");
  await page.locator("#palette[open]").waitFor({ timeout: SOON });
  await page.keyboard.type(text);
}

/** Sets a gain by the palette and waits until page and server agree. */
async function setGain(name, value) {
  await palette(`${name} ${value}`);
  await page.keyboard.press("Enter");
  await becomes(name, value);
  await showsGain(name, value);
}

test("the palette sets a gain, and the tick of effect shown is the server's echo", LIMIT, async () => {
  await tab("gains");
  await setGain("damping.z", 12);
  const echo = await until(() => witness.gains.findLast(({ name }) => name === "damping.z"), SOON, "the echo reaches the witness");
  await until(async () => (await row("damping.z").locator(".tick").innerText()) === `@${echo.tick}`, SOON, `tick ${echo.tick} stands at the gain`);
  assert.match(await page.locator("#last-change").innerText(), new RegExp(`= 12 from tick ${echo.tick}$`));
  assert.equal(await page.locator("#palette").isVisible(), false);
});

test("the palette refuses what is out of range, before the server has to", LIMIT, async () => {
  const old = await valueOf("damping.z");
  await palette("damping.z 99999");
  assert.match(await page.locator("#palette-list [role=option]").first().innerText(), /allowed: 0 to/);
  await page.keyboard.press("Enter");
  assert.equal(await page.locator("#palette").isVisible(), true);
  await page.keyboard.press("Escape");
  assert.equal(await valueOf("damping.z"), old);
});

test("the table lists exactly what differs from the preset, and brings single gains back", LIMIT, async () => {
  await setGain("slope.x", 3);
  await tab("compare");
  const now = await gainsOf();
  const expected = Object.keys(now).filter((name) => Math.abs(now[name].value - now[name].preset_value) > 1e-9);
  assert.deepEqual(await page.locator("#diff-rows tr").evaluateAll((rows) => rows.map((tr) => tr.dataset.gain)), expected);
  const cells = await page.locator('#diff-rows tr[data-gain="damping.z"] td').allInnerTexts();
  const { value, preset_value } = now["damping.z"];
  assert.deepEqual(cells.slice(0, 3), [String(preset_value), String(value), `+${value - preset_value}`]);
  await page.locator("#diff-changed").uncheck();
  assert.equal(await page.locator("#diff-rows tr").count(), Object.keys(now).length);
  await page.locator("#diff-changed").check();
  await page.locator('#diff-rows tr[data-gain="damping.z"] button').click();
  await becomes("damping.z", preset_value);
  await until(async () => (await page.locator("#diff-rows tr").count()) === expected.length - 1, SOON, "its line goes");
});

test("a gain goes back to the preset at its own button, and all of them at one", LIMIT, async () => {
  const { preset_value } = (await gainsOf())["slope.x"];
  await tab("gains");
  await setGain("damping.q1", 5);
  await row("slope.x").locator(".default").click();
  await becomes("slope.x", preset_value);
  await setGain("slope.y", 4);
  await page.locator("#reset-all").click();
  await until(async () => Object.values(await gainsOf()).every((gain) => Math.abs(gain.value - gain.preset_value) < 1e-9), SOON, "every gain is as in the preset");
  await until(async () => (await page.locator(".gain.modified").count()) === 0, SOON, "no gain is marked");
  await page.keyboard.press("Control+z");
  await becomes("slope.y", 4);
  await becomes("damping.q1", 5);
});

test("A and B are kept and switched between, as one step that undo takes back", LIMIT, async () => {
  await tab("compare");
  const a = await valueOf("slope.y");
  await page.locator("#keep-A").click();
  await setGain("slope.y", 2.5);
  await setGain("leak", 1.5);
  await page.locator("#keep-B").click();
  await page.keyboard.press("x");
  await becomes("slope.y", a);
  await page.keyboard.press("x");
  await becomes("slope.y", 2.5);
  await becomes("leak", 1.5);
  await tab("history");
  await until(async () => /set B/.test(await page.locator("#history li").first().innerText()), SOON, "the history says set B");
  await page.keyboard.press("Control+z");
  await becomes("slope.y", a);
  await page.locator("#history button", { hasText: "set B" }).first().click();
  await becomes("slope.y", 2.5);
});

test("a change made elsewhere is shown, marked and attributed", LIMIT, async () => {
  await tab("gains");
  witness.say({ type: "set_gain", name: "slope.z", value: 2.2 });
  await showsGain("slope.z", 2.2);
  await until(async () => /by another client/.test(await page.locator("#last-change").innerText()), SOON, "the last change is somebody else's");
  assert.match(await row("slope.z").getAttribute("class"), /elsewhere|modified/);
  assert.equal(await row("slope.z").locator("input[type=number]").inputValue(), "2.2");
});

test("the override is what is in force, and flies as a scenario", LIMIT, async () => {
  await tab("compare");
  const downloading = page.waitForEvent("download");
  await page.locator("#override-open").click();
  const download = await downloading;
  const text = readFileSync(await download.path(), "utf8");
  assert.equal(await page.locator("#override-text").inputValue(), text);
  assert.equal(download.suggestedFilename(), "a_300g_slow.override.toml");
  await page.locator("#override-close").click();

  // The test merges by hand: it takes the scenario without its own table of gains, and appends the override.
  const whole = readFileSync(path.join(ROOT, SCENARIO), "utf8").replace(/^\[gains[^\]]*\]\n(?:(?!\[).*\n?)*/gm, "");
  const folder = path.join(ROOT, "out");
  mkdirSync(folder, { recursive: true });
  // The file stands beside the scenarios' own folder, because their paths to vehicles are relative.
  const file = path.join(folder, `override-${process.pid}.toml`);
  try {
    writeFileSync(file, `${whole}\n${text}`);
    execFileSync(BINARY, ["check", file], { cwd: ROOT, stdio: "pipe" });
    // The merged scenario has the gains in force.
    const now = await gainsOf();
    assert.match(text, /^preset = "tuned"$/m);
    assert.ok(text.includes(String(now["slope.z"].value)), text);
  } finally {
    rmSync(file);
  }
});

test("restart with a seed flies with it; empty keeps it", LIMIT, async () => {
  await page.locator("#restart-more").click();
  await page.locator("#seed").fill("4711");
  await page.keyboard.press("Enter");
  await until(() => witness.state.seed === 4711, SOON, "the server flies seed 4711");
  await until(async () => (await shown(page)).state.seed === 4711, SOON, "the page knows it");
  await page.locator("#restart-more").click();
  assert.equal(await page.locator("#seed-now").innerText(), "4711");
  await page.locator("#seed-new").click();
  assert.match(await page.locator("#seed").inputValue(), /^\d+$/);
  await page.locator("#seed").fill("");
  const before = witness.state.tick;
  await page.locator("#seed-go").click();
  await until(() => witness.state.tick < before || witness.state.tick < 50, SOON, "the flight starts anew");
  assert.equal(witness.state.seed, 4711);
  await hold(true);
});

test("payload, wind and effects change in the flight, and are shown as the server has them", LIMIT, async () => {
  await tab("world");
  const seen = witness.events.length;
  await page.locator("#payload-number").fill("420");
  await page.keyboard.press("Enter");
  await until(() => Math.abs((witness.state.payload_kg ?? 0) - 0.42) < 1e-9, SOON, "the payload weighs 420 g");
  await until(async () => (await page.locator("#payload-force").innerText()).includes("420 g"), SOON, "the page says so");
  await page.locator("#wind-presets button", { hasText: "3 m/s" }).click();
  await until(() => Math.abs(Math.hypot(...witness.state.wind_m_s) - 3) < WIND_TOLERANCE_M_S, SOON, "3 m/s of wind");
  await page.locator("#wind-from-number").fill("0");
  await page.keyboard.press("Enter");
  await until(() => Math.abs(witness.state.wind_m_s[1] + 3) < WIND_TOLERANCE_M_S && Math.abs(witness.state.wind_m_s[0]) < WIND_TOLERANCE_M_S, SOON, "wind from the north moves the air south");
  const box = page.locator("#effect-ground_effect");
  await box.uncheck();
  await until(() => witness.state.effects_off.includes("ground_effect"), SOON, "the ground effect is off");
  await box.check();
  await until(() => !witness.state.effects_off.includes("ground_effect"), SOON, "and on again");
  // Events belong to ticks and the flight is paused, so one tick is flown.
  await page.keyboard.press("Control+ArrowRight");
  const disturbances = () => witness.events.slice(seen).filter(({ kind }) => kind === "disturbance");
  const events = await until(() => disturbances().length >= 5 && disturbances(), SOON, () => `five changes, events: ${disturbances().map(({ text }) => text).join("; ")}`);
  await page.locator("#events li", { hasText: events[0].text }).first().waitFor({ timeout: SOON });
});

test("the help lists every key that is registered", LIMIT, async () => {
  await page.locator("#scene").focus();
  await page.keyboard.press("?");
  await page.locator("#help[open]").waitFor({ timeout: SOON });
  const listed = await page.locator("#help-keys tr[data-command]").evaluateAll((rows) => rows.map((tr) => tr.dataset.command).filter((id) => id !== ""));
  const registered = await page.evaluate(() => window.__twin.commands.filter(({ keys }) => keys.length > 0).map(({ id }) => id));
  assert.ok(registered.length > 15, "the commands of the console");
  assert.deepEqual(listed.toSorted(), registered.toSorted());
  // In the past the keys of the playhead take precedence; every other key has one meaning.
  const chords = await page.evaluate(() => window.__twin.commands.flatMap(({ id, keys }) => keys.map((key) => ({ id, key }))));
  const twice = chords.filter(({ key }, at) => chords.findIndex((other) => other.key === key) !== at).map(({ key }) => key);
  const unclear = twice.filter((key) => !chords.some((chord) => chord.key === key && chord.id.startsWith("time.")));
  assert.deepEqual(unclear, []);
  await page.keyboard.press("Escape");
});

test("the keyboard alone pauses, changes a gain and takes it back", LIMIT, async () => {
  const keyed = await openFree({ reducedMotion: "reduce" });
  const { keyboard } = keyed.page;
  // The first element that the tab key reaches is a link past the top bar.
  await keyboard.press("Tab");
  assert.equal(await keyed.page.evaluate(() => document.activeElement?.textContent), "To the gains");
  await keyed.page.evaluate(() => document.activeElement?.blur());
  await keyboard.press("Space");
  const inPhase = (phase) => until(async () => (await shown(keyed.page)).state.phase === phase && witness.state.phase === phase, SOON, `page and server are ${phase}`);
  await inPhase("flying");
  await keyboard.press("Space");
  await inPhase("paused");
  await until(() => keyed.page.evaluate(() => !document.querySelector("#desk-lock").disabled), SOON, "the column is free");
  await keyboard.press("g");
  await keyboard.type("damping.x");
  await until(() => keyed.page.locator(".gain:not([hidden])").count().then((count) => count === 1), SOON, "the filter leaves one gain");
  const old = await valueOf("damping.x");
  await until(async () => {
    await keyboard.press("Tab");
    return keyed.page.evaluate(() => document.activeElement?.id === "gain-damping.x");
  }, SOON, "the tab key reaches the slider");
  await keyboard.press("ArrowRight");
  await until(async () => (await valueOf("damping.x")) > old, SOON, "the gain is larger");
  await until(() => keyed.page.evaluate(() => !document.querySelector("#undo").disabled), SOON, "there is something to undo");
  await keyboard.press("Control+z");
  await becomes("damping.x", old);
  const ring = await keyed.page.evaluate(() => getComputedStyle(document.activeElement).outlineStyle);
  assert.equal(ring, "solid", "the focus can be seen");
  await keyed.close();
});

test("on a phone nothing sticks out, and every control is large enough for a finger", LIMIT, async () => {
  const phone = await openFree({ viewport: { width: 390, height: 844 }, hasTouch: true });
  const small = async (where) => {
    const faults = await phone.page.evaluate((least) => {
      const found = [];
      if (document.documentElement.scrollWidth > innerWidth) found.push(`the page is ${document.documentElement.scrollWidth} px wide`);
      for (const node of document.querySelectorAll("button, select, input, summary")) {
        const { width, height, right } = node.getBoundingClientRect();
        if (width === 0 || getComputedStyle(node).visibility === "hidden") continue;
        const label = node.closest("label")?.getBoundingClientRect().height ?? 0;
        if (Math.max(height, label) < least - 0.5) found.push(`${node.id || node.className || node.textContent} is ${height} px high`);
        if (right > innerWidth + 0.5) found.push(`${node.id || node.textContent} ends at ${right}`);
      }
      return found;
    }, FINGER_PX);
    assert.deepEqual(faults, [], where);
  };
  for (const section of ["charts", "desk", "events"]) {
    await phone.page.locator(`#section-${section}`).tap();
    await small(section);
  }
  // The charts scroll between their heading and the timeline, and never cover either.
  await phone.page.locator("#section-charts").tap();
  const scrolls = await phone.page.evaluate(() => ["#charts-section", "#charts"].map((where) => document.querySelector(where)).map(({ scrollHeight, clientHeight }) => scrollHeight > clientHeight + 1));
  assert.deepEqual(scrolls, [false, true]);
  await phone.page.locator("#section-desk").tap();
  for (const name of ["gains", "compare", "history", "world"]) {
    await phone.page.locator(`#tab-${name}`).tap();
    await small(name);
  }
  await phone.close();
});

test("old data lock the tuning column, and fresh data free it", LIMIT, async () => {
  const { port } = twin;
  await twin.stop();
  await until(async () => (await shown(page)).stale, SOON, "the page greys");
  await until(() => page.evaluate(() => document.querySelector("#desk-lock").disabled), SOON, "the column locks");
  await tab("gains");
  assert.equal(await page.locator("#reset-all").isDisabled(), true);
  assert.equal(await row("slope.z").locator("input[type=range]").isDisabled(), true);
  assert.equal(await page.locator("#desk-locked").isVisible(), true);
  twin = await startTwin(SCENARIO, port);
  await until(async () => (await shown(page)).connected, SOON, "the page is back");
  await page.keyboard.press("Space");
  await until(async () => (await shown(page)).state.phase === "paused", SOON, "held");
  await unlocked();
  await page.locator("#link").click();
  await until(async () => Number(await page.locator("#link-rows tr", { hasText: "reconnects" }).locator("td").innerText()) >= 1, SOON, "the reconnect is counted");
});
