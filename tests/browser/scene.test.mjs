// The 3-D view against the real server, in a real browser: the picture agrees with telemetry, and the operator's actions on the
// picture reach the vehicle. No test depends on the speed of the machine.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { freePort, launchBrowser, openConsole, shown, startTwin, until } from "./harness.mjs";
import { Oracle } from "./oracle.mjs";

const SCENARIO = "scenarios/a_300g_slow.toml";
/** Telemetry has poses as f32, which at 10 m is exact to 1e-6 m; drawing may multiply this error by ten. */
const POSE_TOLERANCE_M = 1e-5;
/** Tolerance of arrows, which are computed from f32 channels and poses by a few products. */
const ARROW_TOLERANCE_M = 1e-5;
/** Shorter arrows are not drawn, m. */
const SHORTEST_M = 0.004;
/** Tolerance of the card, which shows millimetres. */
const CARD_TOLERANCE_M = 5.1e-4;
/** The push of the test moves the vehicle at least this far off its reference, m; sensor noise is a tenth of it. */
const PUSHED_M = 0.04;
/** Time limit of a wait, ms. It is long enough for a loaded machine and short against a test's own limit. */
const SOON = 20_000;
const LIMIT = { timeout: 180_000 };

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

const scene = () => page.evaluate(() => window.__twin.scene);
const body = () => oracle.hello.scene.base_body;

async function setPaused(paused) {
  await page.locator("#scene").focus();
  const { state } = await shown(page);
  if ((state.phase === "paused") !== paused) await page.keyboard.press("Space");
  await until(async () => ((await shown(page)).state.phase === "paused") === paused, SOON, `paused is ${paused}`);
}

/** Opens the list of the things to draw, if it is not open. */
async function openList() {
  if (await page.locator("#view").isHidden()) await page.keyboard.press("Shift+V");
  await until(() => page.locator("#view").isVisible(), SOON, "the list is open");
}

/** Starts the flight anew. It hovers for three seconds first, which gives the test enough time. */
async function freshFlight() {
  await page.locator("#scene").focus();
  await setPaused(false);
  // A loaded machine looks only a few times a second: the new flight must stay behind the old one for longer than that.
  await until(async () => (await shown(page)).lastTick > 150, SOON, "the old flight is 1.5 s old");
  const before = (await shown(page)).lastTick;
  await page.keyboard.press("r");
  await until(async () => {
    const { lastTick } = await shown(page);
    return lastTick >= 0 && lastTick < before;
  }, SOON, "the flight starts anew");
}

async function inStep() {
  return until(async () => {
    const now = await shown(page);
    return now.lastTick === oracle.lastTick && now;
  }, SOON, () => `page at the oracle's tick ${oracle.lastTick}`);
}

/** The vector [a b c] turned by the quaternion [w x y z], computed by the rotation matrix. */
function turned([w, x, y, z], [a, b, c]) {
  return [
    (1 - 2 * (y * y + z * z)) * a + 2 * (x * y - w * z) * b + 2 * (x * z + w * y) * c,
    2 * (x * y + w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z - w * x) * c,
    2 * (x * z - w * y) * a + 2 * (y * z + w * x) * b + (1 - 2 * (x * x + y * y)) * c,
  ];
}

function near(found, wanted, tolerance, what) {
  wanted.forEach((value, k) => assert.ok(Math.abs(found[k] - value) <= tolerance, `${what}[${k}]: ${found[k]}, wanted ${value}`));
}

test("a flight that is held is drawn exactly where telemetry says, tick by tick", LIMIT, async () => {
  await until(async () => (await shown(page)).lastTick > 50, SOON, "half a second flown");
  await setPaused(true);
  for (let step = 0; step < 3; step += 1) {
    const now = await inStep();
    for (const [name, pose] of oracle.poses) {
      const drawn = [...now.bodies[name].position, ...now.bodies[name].quaternion_wxyz];
      if (pose.every(Number.isFinite)) near(drawn, pose, POSE_TOLERANCE_M, name);
    }
    const tick = now.lastTick;
    await page.keyboard.press("Control+ArrowRight");
    await until(async () => (await shown(page)).lastTick > tick, SOON, "one tick later");
  }
});

test("arrows are as long and point as the channels say", LIMIT, async () => {
  for (const [kind, key] of [["total_thrust", "Shift+Y"], ["estimate", "Shift+E"], ["adapter", "Shift+S"]]) {
    if (!(await scene()).shown[kind]) await page.keyboard.press(key);
  }
  await inStep();
  const { arrows, m_per_n: scale } = await until(async () => {
    const now = await scene();
    return now.arrows.estimate !== undefined && now.arrows.thrust_total !== undefined && now;
  }, SOON, "arrows of the estimate and of the total thrust");
  const pose = oracle.poses.get(body());
  const [position, attitude] = [pose.slice(0, 3), pose.slice(3)];
  const up = turned(attitude, [0, 0, 1]);
  let total = 0;
  oracle.hello.scene.rotors.forEach(({ position_in_body: hub }, k) => {
    const thrust = oracle.channels.get(`rotor.${k}`);
    total += thrust;
    near(arrows[`rotor.${k}`].vector, up.map((v) => v * thrust * scale), ARROW_TOLERANCE_M, `rotor ${k}`);
    near(arrows[`rotor.${k}`].foot, turned(attitude, hub).map((v, i) => v + position[i]), ARROW_TOLERANCE_M, `hub ${k}`);
  });
  near(arrows.thrust_total.vector, up.map((v) => v * total * scale), ARROW_TOLERANCE_M, "total thrust");
  const triple = (stem) => ["x", "y", "z"].map((axis) => oracle.channels.get(`${stem}.${axis}`));
  const estimate = triple("r_hat");
  near(arrows.estimate.vector, estimate.map((v) => v * scale), ARROW_TOLERANCE_M, "estimate");
  const base = triple("base");
  const share = triple("adapted").map((v, k) => (v - base[k]) * scale);
  // A very short arrow has no visible direction, so the page does not draw it.
  if (Math.hypot(...share) >= SHORTEST_M) near(arrows.adapter.vector, share, ARROW_TOLERANCE_M, "adapter's share");
  else assert.equal(arrows.adapter, undefined);
  // In hover the thrust carries a vehicle of about 3 kg, so this bound also checks the unit.
  assert.ok(total > 20 && total < 45, `total thrust ${total} N`);
});

test("T looks straight down, with y up in the picture", LIMIT, async () => {
  await page.keyboard.press("t");
  const top = await until(async () => {
    const now = await scene();
    return now.mode === "top" && !now.moving && now;
  }, SOON, "the camera is above");
  const { position, target, up_in_picture: up } = top.camera;
  assert.ok(Math.hypot(position[0] - target[0], position[1] - target[1]) < 0.01 * (position[2] - target[2]), "straight above");
  near(up, [0, 1, 0], 1e-3, "up in the picture");
  assert.equal(await page.locator("#camera-top").getAttribute("aria-pressed"), "true");
});

test("a click chooses the body under it, and its card tells the pose", LIMIT, async () => {
  const [x, y] = (await scene()).on_page[body()];
  await page.mouse.click(x, y);
  await until(async () => (await scene()).chosen === body(), SOON, "the vehicle's root is chosen");
  const card = page.locator("#body-card");
  assert.equal(await card.locator("h3").innerText(), body());
  const told = async () => ((await card.locator("dt", { hasText: "x y z" }).locator("xpath=following-sibling::dd[1]").innerText()).replaceAll("−", "-").match(/-?\d+\.\d+/g) ?? []).map(Number);
  await inStep();
  near(await told(), oracle.poses.get(body()).slice(0, 3), CARD_TOLERANCE_M, "card");
  assert.equal((await scene()).mode, "top", "a click leaves the camera alone");
});

test("keys choose bodies in turn, Escape chooses none", LIMIT, async () => {
  await page.locator("#scene").focus();
  const names = oracle.hello.scene.bodies.map(({ name }) => name);
  const at = names.indexOf((await scene()).chosen);
  await page.keyboard.press("n");
  assert.equal((await scene()).chosen, names[(at + 1) % names.length]);
  await page.keyboard.press("Shift+N");
  assert.equal((await scene()).chosen, names[at]);
  await page.keyboard.press("Escape");
  assert.equal((await scene()).chosen, null);
  await until(() => page.locator("#body-card").isHidden(), SOON, "the card is gone");
});

test("Ctrl+drag pushes the vehicle off its reference, and the camera stands still", LIMIT, async () => {
  await freshFlight();
  const error = async () => page.evaluate(() => window.__twin.channels["chi.x"] - window.__twin.channels["chi_des.x"]);
  const start = await error();
  const { camera, on_page } = await scene();
  const [x, y] = on_page[body()];
  await page.mouse.move(x, y);
  await page.keyboard.down("Control");
  await page.mouse.down();
  await page.mouse.move(x + 150, y, { steps: 3 });
  const held = await until(async () => (await scene()).push_n, SOON, "the vehicle is held");
  assert.ok(held[0] > 1 && Math.abs(held[1]) < 0.3 * held[0] && Math.hypot(...held) <= 15 + 1e-6, `push ${held}`);
  await until(async () => (await error()) - start > PUSHED_M, SOON, "the vehicle gives way towards +x");
  near((await scene()).camera.position, camera.position, 1e-9, "camera");
  await page.mouse.up();
  await page.keyboard.up("Control");
  assert.equal((await scene()).push_n, null);
  await page.locator("#events li", { hasText: "push" }).first().waitFor({ timeout: SOON });
});

test("Escape lets go of a push", LIMIT, async () => {
  await freshFlight();
  const [x, y] = (await scene()).on_page[body()];
  await page.mouse.move(x, y);
  await page.keyboard.down("Control");
  await page.mouse.down();
  await page.mouse.move(x + 5, y + 5);
  await until(async () => (await scene()).push_n, SOON, "the vehicle is held");
  await page.keyboard.up("Control");
  await page.keyboard.press("Escape");
  assert.equal((await scene()).push_n, null);
  await page.mouse.up();
});

test("buttons push without a mouse", LIMIT, async () => {
  await freshFlight();
  await openList();
  const button = page.locator("#view .view-push button", { hasText: "+y" });
  await until(() => button.isEnabled(), SOON, "the flight can be pushed");
  await button.press("Enter");
  await page.locator("#events li", { hasText: /push .*0\.0 5\.0 0\.0/ }).first().waitFor({ timeout: SOON });
  await page.keyboard.press("Escape");
  await until(() => page.locator("#view").isHidden(), SOON, "the list is closed");
});

test("what is drawn is kept over a reload", LIMIT, async () => {
  await page.locator("#scene").focus();
  const before = (await scene()).shown;
  await page.keyboard.press("Shift+E");
  await openList();
  await page.locator("#view-payload").click();
  await page.locator("#view-span").selectOption("5");
  await page.reload();
  await until(() => page.evaluate(() => (window.__twin?.lastTick ?? -1) >= 0), SOON, "the page shows the flight");
  const after = await scene();
  assert.deepEqual(after.shown, { ...before, estimate: !before.estimate, payload: !before.payload });
  assert.equal(await page.locator("#view-estimate").isChecked(), !before.estimate);
  assert.equal(await page.locator("#view-span").inputValue(), "5");
  assert.equal(after.frames.includes("payload"), !before.payload);
  assert.equal("estimate" in after.arrows, !before.estimate);
});

test("a dead server's forces are not drawn, and nobody can push", LIMIT, async () => {
  await until(async () => "rotor.0" in (await scene()).arrows, SOON, "thrust is drawn");
  await twin.stop();
  await until(async () => (await shown(page)).stale, SOON, "the page greys");
  await until(async () => Object.keys((await scene()).arrows).length === 0, SOON, "no arrow is left");
  await openList();
  await until(() => page.locator("#view .view-push button").first().isDisabled(), SOON, "the push is out of reach");
  assert.deepEqual(view.complaints.filter((text) => !/GPU stall|swiftshader|WebSocket|ERR_CONNECTION/i.test(text)), []);
});
