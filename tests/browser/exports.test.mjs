// `twin export meshcat` and `twin export viser -o page.html` write one file each, in which a stock viewer plays the flight without a
// network.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { launchBrowser, NOISE, openPage, runTwin, scratch, until, VIEWERS } from "./harness.mjs";

const SOON = 60_000;
const LIMIT = { timeout: 180_000 };
const own = scratch("exports");
let browser;

const open = (file, ready) => openPage(browser, pathToFileURL(own.file(file)).href, ready, { viewport: { width: 1280, height: 800 }, offline: true });

before(async () => {
  assert.ok(existsSync(VIEWERS), `no viewers at ${VIEWERS}: run twin viewers fetch --dir target/viewers`);
  const flight = own.file("flight.mcap");
  // In six seconds the vehicle climbs and sets off; the verdict is that it did not arrive.
  runTwin(["fly", "scenarios/a_300g_slow.toml", "--headless", "--json", "--set", "time_limit_s=6", "--record", flight], [0, 1]);
  runTwin(["export", "meshcat", flight, "-o", own.file("meshcat.html"), "--viewer-dir", VIEWERS], [0, 1]);
  runTwin(["export", "viser", flight, "-o", own.file("viser.html"), "--viewer-dir", VIEWERS], [0, 1]);
  browser = await launchBrowser();
}, LIMIT);

after(async () => {
  await browser?.close();
  own.remove();
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
  // The page plays in real time. Two pictures are 40 ms apart and no body is faster than 1 m/s, so they differ by at most 0.04 m.
  let off;
  await until(async () => (off = await worst()) < 0.04, SOON, () => `viser arrives where MeshCat does, now ${off} m off`);
  for (const { complaints, asked } of [meshcat, viser]) {
    assert.deepEqual(complaints.filter((text) => !NOISE.test(text)), []);
    assert.deepEqual(asked.filter((url) => /^(https?|wss?):/.test(url)), []);
  }
  await Promise.all([meshcat.close(), viser.close()]);
});
