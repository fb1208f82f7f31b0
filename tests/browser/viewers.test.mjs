// The stock MeshCat and viser viewers from `twin viewers fetch` (in target/viewers) and the console watch one flight.
import assert from "node:assert/strict";
import { existsSync, mkdirSync } from "node:fs";
import path from "node:path";
import { after, before, test } from "node:test";
import { freePort, launchBrowser, NOISE, openConsole, openPage, ROOT, shown, startTwin, until, VIEWERS } from "./harness.mjs";
import { Oracle } from "./oracle.mjs";

const SCENARIO = "scenarios/a_300g_slow.toml";
/** Telemetry has poses as f32, which at 10 m is exact to 1e-6 m; drawing may multiply this error by ten. */
const POSE_TOLERANCE = 1e-5;
/** Time limit of a wait, long enough for three pages that render in software, ms. */
const SOON = 60_000;
const LIMIT = { timeout: 240_000 };

let browser;
let twin;
let oracle;
let meshcat;
let viser;
let drake;
let board;

const open = (where, ready) => openPage(browser, twin.url + where, ready, { viewport: { width: 1280, height: 800 } });

const openMeshcat = () => open("/meshcat/", () => Boolean(globalThis.viewer?.gui_controllers?.["slope.x"]));
// Drake ships the current MeshCat.
const openDrake = () => open("/drake/", () => Boolean(globalThis.viewer?.gui_controllers?.["slope.x"]));
// The stock client exposes its scene as `__viserMutable` and its charts as `__viserTestpoints`.
const openViser = () => open("/viser", () => Boolean(globalThis.__viserMutable?.nodeRefFromName?.["/twin/reference"] && globalThis.__viserTestpoints?.uplots));

/** World position (m) and quaternion (w first) of each body in MeshCat's scene; the nodes below /twin are in the world frame. */
const meshcatPoses = (names) => names.map((name) => {
  const { position: p, quaternion: q } = globalThis.viewer.scene_tree.find(["twin", name]).object;
  return [p.x, p.y, p.z, q.w, q.x, q.y, q.z];
});

const viserPoses = (names) => names.map((name) => {
  const { position: p, quaternion: q } = globalThis.__viserMutable.nodeRefFromName[`/twin/${name}`];
  return [p.x, p.y, p.z, q.w, q.x, q.y, q.z];
});

const consolePoses = (names) => names.map((name) => {
  const { position, quaternion_wxyz } = globalThis.__twin.bodies[name];
  return [...position, ...quaternion_wxyz];
});

/** The largest difference from telemetry; a quaternion and its negative are the same rotation. */
function worst(names, drawn) {
  let most = 0;
  names.forEach((name, index) => {
    const wanted = [...oracle.poses.get(name)];
    const sign = Math.sign([3, 4, 5, 6].reduce((sum, k) => sum + wanted[k] * drawn[index][k], 0)) || 1;
    wanted.forEach((value, k) => (most = Math.max(most, Math.abs(value - (k < 3 ? 1 : sign) * drawn[index][k]))));
  });
  return most;
}

const gain = async (name) => {
  const { gains } = await (await fetch(`${twin.url}/api/gains`)).json();
  return gains.find((one) => one.name === name).value;
};
const state = async () => (await fetch(`${twin.url}/api/state`)).json();
const inMeshcat = (name) => meshcat.page.evaluate((name) => globalThis.viewer.gui_controllers[name].getValue(), name);
const press = (name) => meshcat.page.evaluate((name) => globalThis.viewer.gui_controllers[name].fire(), name);
// viser gives each control its identifier. A slider has its exact value in a hidden field beside the rounded one.
const viserSlider = (name) => viser.page.locator(`[id="gain.${name}"]`);
const inViser = async (name) => Number(await viserSlider(name).locator("input[type=hidden]").inputValue());
const viserField = (name) => viserSlider(name).locator('xpath=..//input[@inputmode="decimal"]');

before(async () => {
  assert.ok(existsSync(VIEWERS), `no viewers at ${VIEWERS}: run twin viewers fetch --dir target/viewers --drake`);
  mkdirSync(path.join(ROOT, "out"), { recursive: true });
  browser = await launchBrowser();
  twin = await startTwin(SCENARIO, await freePort(), ["--viewer-dir", VIEWERS]);
  oracle = await Oracle.connect(twin.url);
  // The console opens first, because it has a shorter time limit than the stock viewers, which need most of the processor.
  board = await openConsole(browser, twin.url);
  meshcat = await openMeshcat();
  viser = await openViser();
  drake = await openDrake();
}, LIMIT);

after(async () => {
  oracle?.close();
  await browser?.close();
  await twin?.stop();
});

test("four viewers draw one live flight, viser with its two charts, and complain about nothing", LIMIT, async () => {
  // Time span and number of known values of each of viser's charts.
  const charts = () => viser.page.evaluate(() =>
    Object.values(globalThis.__viserTestpoints.uplots).map(({ chart }) => ({
      from: chart.scales.x.min,
      to: chart.scales.x.max,
      known: chart.data.slice(1).map((series) => Array.from(series).filter(Number.isFinite).length),
    })));
  await until(async () => {
    const drawn = await charts();
    return drawn.length === 2 && drawn.every(({ from, to, known }) => to - from > 2 && known.every((count) => count > 20));
  }, SOON, "both charts of viser show seconds of flight");
  await meshcat.page.screenshot({ path: path.join(ROOT, "out", "meshcat.png"), timeout: SOON });
  await viser.page.screenshot({ path: path.join(ROOT, "out", "viser.png"), timeout: SOON });
  await drake.page.screenshot({ path: path.join(ROOT, "out", "drake.png"), timeout: SOON });
  await board.page.screenshot({ path: path.join(ROOT, "out", "console.png"), timeout: SOON });
  for (const { complaints } of [meshcat, viser, drake]) assert.deepEqual(complaints.filter((text) => !NOISE.test(text)), []);
});

test("MeshCat's buttons restart and hold the flight, and all scenes stand where telemetry says", LIMIT, async () => {
  await press("Restart");
  await until(async () => { const { phase, tick } = await state(); return phase === "flying" && tick > 100 && tick < 3000; }, SOON, "the flight flies anew");
  await press("Pause / Continue");
  await until(async () => (await state()).phase === "paused", SOON, "the flight is paused");
  const { tick } = await state();
  // `tick` is the number of ticks flown, so the newest tick has this number less one.
  await until(() => oracle.lastTick >= tick - 1, SOON, () => `the last tick of ${tick} came, not ${oracle.lastTick}`);
  const names = [...oracle.poses.keys()].filter((name) => [...oracle.poses.get(name)].every(Number.isFinite));
  assert.ok(names.length > 5, `bodies: ${names.join(" ")}`);
  const late = await openMeshcat();
  for (const [who, page, read] of [["MeshCat", meshcat.page, meshcatPoses], ["the current MeshCat", drake.page, meshcatPoses], ["viser", viser.page, viserPoses], ["the console", board.page, consolePoses], ["a late MeshCat", late.page, meshcatPoses]]) {
    let off = NaN;
    await until(async () => (off = worst(names, await page.evaluate(read, names))) <= POSE_TOLERANCE, SOON, () => `${who} stands at the tick, now ${off} off`);
  }
  await late.close();
});

test("a gain moved in any of the three reaches the controller and shows in the other two", LIMIT, async () => {
  const everywhere = (name, value) => {
    let said;
    return until(async () => {
      said = { server: await gain(name), console: (await shown(board.page)).gains[name], MeshCat: await inMeshcat(name), viser: await inViser(name) };
      return Object.values(said).every((one) => Math.abs(one - value) < 1e-9);
    }, SOON, () => `${name} = ${value} everywhere, but ${JSON.stringify(said)}`);
  };
  await meshcat.page.evaluate(() => globalThis.viewer.gui_controllers["slope.x"].setValue(1.5));
  await everywhere("slope.x", 1.5);
  await viserField("slope.x").fill("2.5");
  await viserField("slope.x").press("Enter");
  await everywhere("slope.x", 2.5);
  const field = board.page.locator('.gain[data-gain="slope.x"] input[type=number]');
  await field.fill("0.5");
  await field.press("Enter");
  await everywhere("slope.x", 0.5);
});

test("both stock viewers draw the trails, and each hides them for itself alone", LIMIT, async () => {
  const inMeshcat = () => meshcat.page.evaluate(() => {
    const { object } = globalThis.viewer.scene_tree.find(["twin", "trails"]);
    const ends = [];
    object.traverse((one) => one.isLineSegments && ends.push(one.geometry.attributes.position.count));
    return { visible: object.visible, ends };
  });
  const inViser = () => viser.page.evaluate(() => {
    const nodes = globalThis.__viserMutable.nodeRefFromName;
    let lines = 0;
    nodes["/twin/trails"]?.traverse((one) => (lines += one.isLineSegments2 || one.isLine2 || one.isLineSegments ? 1 : 0));
    return { visible: nodes["/twin/trails"]?.visible, lines };
  });
  let said;
  const both = (fits, why) => until(async () => fits((said = { meshcat: await inMeshcat(), viser: await inViser() })), SOON, () => `${why}: ${JSON.stringify(said)}`);
  await both(({ meshcat, viser }) => meshcat.ends.length === 2 && meshcat.ends.every((count) => count > 4) && viser.lines === 2, "two lines in each");
  await press("Show / hide trails");
  await both(({ meshcat, viser }) => !meshcat.visible && viser.visible, "hidden in MeshCat alone");
  await press("Show / hide trails");
  await viser.page.locator('[id="show.trails"]').click();
  await both(({ meshcat, viser }) => meshcat.visible && !viser.visible, "hidden in viser alone");
  await viser.page.locator('[id="show.trails"]').click();
  await both(({ meshcat, viser }) => meshcat.visible && viser.visible, "shown in both");
});

test("both stock viewers point an arrow as long as the residual, viser names what it draws, and MeshCat saves its picture", LIMIT, async () => {
  // After some seconds of flight both arrows show the weight of more than 3 kg, at 12.5 mm per newton.
  const heavy = (length) => length > 0.3 && length < 0.6;
  const needle = () => meshcat.page.evaluate(() => globalThis.viewer.scene_tree.find(["twin", "forces", "estimate"]).object.scale.y);
  await until(async () => heavy(await needle()), SOON, "MeshCat's arrow");
  // viser draws shafts and heads as two instanced meshes below the arrow's node.
  const inViser = () => viser.page.evaluate(() => {
    const nodes = globalThis.__viserMutable.nodeRefFromName;
    const counts = (name) => {
      const found = [];
      nodes[name]?.traverse((one) => one.isInstancedMesh && found.push(one.count));
      return found;
    };
    return { arrow: counts("/twin/forces/estimate"), marks: counts("/twin/trails/attitude"), labels: Object.keys(nodes).filter((name) => name.endsWith("/label")) };
  });
  let said;
  const drawn = async () => {
    said = await inViser();
    return said.labels.length === 3 && said.arrow.some((count) => count === 1) && said.marks.some((count) => count > 2);
  };
  await until(drawn, SOON, () => `arrow, marks and labels of viser: ${JSON.stringify(said)}`);
  const [saved] = await Promise.all([meshcat.page.waitForEvent("download", { timeout: SOON }), press("Save picture")]);
  assert.match(saved.suggestedFilename(), /\.png$/);
  await press("Show / hide forces");
  await until(() => meshcat.page.evaluate(() => !globalThis.viewer.scene_tree.find(["twin", "forces"]).object.visible), SOON, "hidden");
});

test("the current MeshCat holds the flight and moves a gain with keys, sets a gain, and shows the real-time rate", LIMIT, async () => {
  assert.notEqual((await state()).phase, "ended");
  const before = (await state()).phase;
  await drake.page.bringToFront();
  await drake.page.mouse.click(300, 500);
  await drake.page.keyboard.press("Space");
  await until(async () => (await state()).phase !== before, SOON, "the space bar turned it");
  await drake.page.keyboard.press("Space");
  await until(async () => (await state()).phase === before, SOON, "and turned it back");
  await drake.page.evaluate(() => globalThis.viewer.gui_controllers["slope.y"].setValue(2.5));
  await until(async () => (await gain("slope.y")) === 2.5, SOON, "its slider sets the gain");
  await until(async () => (await inMeshcat("slope.y")) === 2.5, SOON, "the other MeshCat shows it");
  // The keys of a slider move it by its step.
  const { gains } = await (await fetch(`${twin.url}/api/gains`)).json();
  const { value, step } = gains.find(({ name }) => name === "reset_threshold");
  const threshold = (wanted) => until(async () => Math.abs((await gain("reset_threshold")) - wanted) < 1e-9, SOON, `a reset threshold of ${wanted}`);
  await drake.page.keyboard.press("BracketRight");
  await threshold(value + step);
  await drake.page.keyboard.press("BracketLeft");
  await threshold(value);
  const chart = () => drake.page.evaluate(() => getComputedStyle(document.getElementById("stats-plot")).display);
  assert.equal(await chart(), "block");
});

test("after a restart from viser's list every scene is of the new flight", LIMIT, async () => {
  await viser.page.locator("#scenario").click();
  await viser.page.getByRole("option", { name: "hover", exact: true }).click();
  await until(async () => (await state()).scenario === "hover", SOON, "hover flies");
  await until(async () => (await shown(board.page)).scenario === "hover", SOON, "the console shows it");
  await until(() => viser.page.evaluate(() => Boolean(globalThis.__viserMutable.nodeRefFromName["/twin/reference"])), SOON, "viser drew it");
  await until(() => meshcat.page.evaluate(() => Boolean(globalThis.viewer.scene_tree.find(["twin", "reference"]).object)), SOON, "MeshCat drew it");
});
