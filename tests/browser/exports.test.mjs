// `twin export meshcat` and `twin export viser -o page.html`: one file each, no network, the flight played by the stock viewers.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { BINARY, launchBrowser, ROOT, until } from "./harness.mjs";

const VIEWERS = path.resolve(ROOT, process.env.TWIN_VIEWERS ?? "target/viewers");
const SOON = 60_000;
const LIMIT = { timeout: 180_000 };
/** What the stock clients say of the machine, and of a page without a server. */
const NOISE = /GPU stall|swiftshader|WebGL|GroupMarkerNotSet|deprecated|favicon|ERR_INTERNET_DISCONNECTED/i;
const folder = mkdtempSync(path.join(tmpdir(), "twin-exports-"));
const asked = [];
let browser;

function twin(...words) {
  const run = spawnSync(BINARY, words, { cwd: ROOT, encoding: "utf8" });
  assert.ok(run.status === 0 || run.status === 1, `twin ${words.join(" ")}: ${run.stderr}`);
}

async function open(file, ready) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, offline: true });
  const page = await context.newPage();
  const faults = [];
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  page.on("request", (request) => asked.push(request.url()));
  await page.goto(pathToFileURL(path.join(folder, file)).href, { waitUntil: "commit" });
  await until(() => page.evaluate(ready), SOON, () => `${file} shows the flight; it said ${faults.join(" | ")}`);
  return { page, faults, close: () => context.close() };
}

before(async () => {
  assert.ok(existsSync(VIEWERS), `no viewers at ${VIEWERS}: run twin viewers fetch --dir target/viewers`);
  const flight = path.join(folder, "flight.mcap");
  // Six seconds: it climbs and sets off, and is told that it did not arrive.
  twin("fly", "scenarios/a_300g_slow.toml", "--headless", "--json", "--set", "time_limit_s=6", "--record", flight);
  twin("export", "meshcat", flight, "-o", path.join(folder, "meshcat.html"), "--viewer-dir", VIEWERS);
  twin("export", "viser", flight, "-o", path.join(folder, "viser.html"), "--viewer-dir", VIEWERS);
  browser = await launchBrowser();
}, LIMIT);

after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

test("both pages play the same flight in the stock viewers, without a network", LIMIT, async () => {
  const meshcat = await open("meshcat.html", () => (globalThis.viewer?.animator?.actions?.length ?? 0) > 5);
  const flown = await meshcat.page.evaluate(() => {
    const { animator, scene_tree: tree } = globalThis.viewer;
    animator.pause();
    const names = Object.keys(tree.find(["twin"]).children).filter((name) => name !== "trails");
    const at = (t) => {
      animator.seek(t);
      return names.map((name) => {
        const { position: p, quaternion: q } = tree.find(["twin", name]).object;
        return [p.x, p.y, p.z, q.w, q.x, q.y, q.z];
      });
    };
    return { names, start: at(0), end: at(animator.duration), duration: animator.duration };
  });
  assert.ok(Math.abs(flown.duration - 6) < 0.1, `${flown.duration} s`);
  const reference = flown.names.indexOf("reference");
  const way = Math.hypot(...[0, 1, 2].map((k) => flown.end[reference][k] - flown.start[reference][k]));
  assert.ok(way > 0.2, `the reference went ${way} m`);

  const viser = await open("viser.html", () => Boolean(globalThis.__viserMutable?.nodeRefFromName?.["/twin/reference"]));
  const worst = () => viser.page.evaluate(({ names, end }) => {
    let most = 0;
    names.forEach((name, index) => {
      const node = globalThis.__viserMutable.nodeRefFromName[`/twin/${name}`];
      const p = node.position;
      [p.x, p.y, p.z].forEach((value, k) => (most = Math.max(most, Math.abs(value - end[index][k]))));
    });
    return most;
  }, flown);
  // The page plays in real time; the last picture and the one before are 40 ms apart, and nothing flies faster than 1 m/s.
  let off;
  await until(async () => (off = await worst()) < 0.04, SOON, () => `viser arrives where MeshCat does, now ${off} m off`);
  for (const { faults } of [meshcat, viser]) assert.deepEqual(faults.filter((text) => !NOISE.test(text)), []);
  assert.deepEqual(asked.filter((url) => /^(https?|wss?):/.test(url)), []);
  await Promise.all([meshcat.close(), viser.close()]);
});
