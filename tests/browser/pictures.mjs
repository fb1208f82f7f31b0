// Makes the pictures of the README and the guide: node tests/browser/pictures.mjs [--at 24.7]
// It needs the stock viewers (`twin viewers fetch --dir target/viewers --drake`). Four viewers watch one flight at the same time.
import { existsSync, statSync } from "node:fs";
import path from "node:path";
import { parseArgs } from "node:util";
import { freePort, launchBrowser, openConsole, pause, ROOT, startTwin, until } from "./harness.mjs";

const { values: options } = parseArgs({ options: { at: { type: "string", default: "24.7" } } });
const SCENARIO = "scenarios/a_500g_fast.toml";
const VIEWERS = path.resolve(ROOT, process.env.TWIN_VIEWERS ?? "target/viewers");
const FOLDER = path.join(ROOT, "web", "screenshots");
const CONSOLE = { viewport: { width: 1600, height: 900 }, layout: "fly" };
/** Size of a quarter of the composed picture, px. */
const QUARTER = { width: 1040, height: 650 };
const SOON = 120_000;
/** Title of each quarter, path of its page, and a condition that holds when the page shows the flight. */
const STOCK = [
  ["MeshCat 0.3.2 (the wheel's viewer)", "/meshcat/", () => Boolean(globalThis.viewer?.gui_controllers?.["slope.x"])],
  ["MeshCat as Drake 1.51.1 ships it", "/drake/", () => Boolean(globalThis.viewer?.gui_controllers?.["slope.x"])],
  ["viser 1.1.1", "/viser", () => Boolean(globalThis.__viserMutable?.nodeRefFromName?.["/twin/reference"] && globalThis.__viserTestpoints?.uplots)],
];

if (!existsSync(VIEWERS)) throw new Error(`no viewers at ${VIEWERS}: run twin viewers fetch --dir target/viewers --drake`);
const browser = await launchBrowser();
const twin = await startTwin(SCENARIO, await freePort(), ["--viewer-dir", VIEWERS]);
const state = async () => (await fetch(`${twin.url}/api/state`)).json();
const reached = () => until(async () => (await state()).t_s >= Number(options.at), SOON, `the flight is at ${options.at} s`);

async function open(where, ready) {
  const page = await (await browser.newContext({ viewport: QUARTER, colorScheme: "dark" })).newPage();
  await page.goto(twin.url + where, { waitUntil: "commit" });
  await until(() => page.evaluate(ready), SOON, `${where} shows the flight`);
  return page;
}

try {
  const { page: board } = await openConsole(browser, twin.url, CONSOLE);
  const stock = [];
  for (const [title, where, ready] of STOCK) stock.push([title, await open(where, ready)]);
  for (const [, page] of stock) await page.evaluate(() => globalThis.viewer?.gui?.open?.());
  // The flight starts once more, so that every chart and trail shows it from its start.
  await board.keyboard.press("r");
  await until(async () => (await state()).t_s < 5, SOON, "the flight flies anew");
  await reached();
  await board.keyboard.press("Space");
  await until(async () => (await state()).phase === "paused", SOON, "the flight is held");
  // Closes viser's notification that it draws in software.
  await stock[2][1].evaluate(() => document.querySelectorAll(".mantine-Notification-closeButton").forEach((button) => button.click()));
  await pause(4000);
  const quarters = [["The console", await board.screenshot({ path: path.join(FOLDER, "console-dark.png"), timeout: SOON })]];
  await board.click("#theme");
  await pause(3000);
  await board.screenshot({ path: path.join(FOLDER, "console-light.png"), timeout: SOON });
  for (const [title, page] of stock) quarters.push([title, await page.screenshot({ timeout: SOON })]);
  const cell = ([title, picture]) => `<figure><img src="data:image/png;base64,${picture.toString("base64")}"><figcaption>${title}</figcaption></figure>`;
  const sheet = await (await browser.newContext({ viewport: { width: 1600, height: 1000 } })).newPage();
  await sheet.setContent(`<style>
    body { margin: 0; display: grid; grid-template: 1fr 1fr / 1fr 1fr; gap: 4px; background: #000; height: 100vh }
    figure { margin: 0; position: relative; overflow: hidden; background: #10141a }
    img { width: 100%; height: 100%; object-fit: contain }
    figcaption { position: absolute; left: 8px; bottom: 8px; padding: 3px 8px; font: 15px system-ui, sans-serif; color: #fff; background: #000a; border-radius: 4px }
  </style>${quarters.map(cell).join("")}`);
  await pause(1000);
  const file = path.join(FOLDER, "viewers.jpg");
  await sheet.screenshot({ path: file, type: "jpeg", quality: 82 });
  for (const name of ["console-dark.png", "console-light.png", "viewers.jpg"]) console.log(name, `${(statSync(path.join(FOLDER, name)).size / 1e3).toFixed(0)} kB`);
} finally {
  await browser.close();
  await twin.stop();
}
