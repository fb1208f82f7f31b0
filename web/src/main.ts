// The console: one store fed by one link, three views on it, one frame loop.
import { handReading } from "./panels/handReading";
import { Store } from "./data/store";
import { installHooks } from "./hooks";
import { clockMs, Link } from "./link/link";
import { cameraButtons } from "./panels/cameraButtons";
import { byId, setText } from "./panels/dom";
import { EventLog } from "./panels/events";
import { GainPanel } from "./panels/gains";
import { startKeys } from "./panels/keys";
import { notify } from "./panels/notices";
import { readPalette, startTheme } from "./panels/theme";
import { TopBar } from "./panels/topbar";
import { ChartColumn } from "./plots/column";
import { preferProcessorCanvas } from "./plots/software";
import { PROTOCOL_VERSION, type ServerMessage } from "./protocol";
import { World } from "./scene/world";

const READINGS_EVERY_MS = 100;

const store = new Store();
const link = new Link({ message, telemetry, unreadable: (text) => notify("error", text), connection });
startTheme(byId("theme"), (palette) => {
  world?.recolor(palette);
  charts.recolor(palette);
});
const palette = readPalette();
const world = buildWorld();
if (world?.software ?? true) preferProcessorCanvas();
const charts = new ChartColumn(store, palette, world?.software ?? true);
const gains = new GainPanel((request) => link.send(request));
const log = new EventLog();
const bar = new TopBar(store, link);
const cameras = cameraButtons(() => world);
startKeys({
  pause: () => bar.togglePause(),
  step: () => bar.step(),
  restart: () => bar.restart(),
  undo: () => gains.undo(),
  redo: () => gains.redo(),
  overview: cameras.overview,
  follow: cameras.follow,
  hand: cameras.hand,
});
installHooks(store, link, gains, () => world);
let retryAt = 0;
let readingsAt = 0;
const address = new URL("/ws", location.href);
address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
link.open(address.href);
requestAnimationFrame(frame);

function buildWorld(): World | null {
  try {
    return new World(byId<HTMLCanvasElement>("scene"), byId("hand"), palette, () => cameras.show());
  } catch (error) {
    notify("error", `no 3-D view, because this browser offers no WebGL 2 (${error instanceof Error ? error.message : "unknown reason"}); charts and gains work`);
    return null;
  }
}

function message(received: ServerMessage): void {
  switch (received.type) {
    case "hello":
      return hello(received);
    case "state":
      store.state = received;
      return bar.show();
    case "gain":
      return gains.echo(received);
    case "gains":
      return gains.replace(received);
    case "events":
      store.addEvents(received.events);
      bar.show();
      return log.add(received.events);
    case "notice":
      if (received.level !== "info") gains.refused();
      return notify(received.level, received.text);
    case "reset":
      store.clear();
      world?.clear();
      charts.redraw();
      return log.rebuild([]);
    case "pong":
  }
}

function hello(received: Extract<ServerMessage, { type: "hello" }>): void {
  if (received.protocol !== PROTOCOL_VERSION) {
    notify("error", `the server speaks protocol ${received.protocol}, this page ${PROTOCOL_VERSION}: reload the page`);
    return;
  }
  store.accept(received);
  world?.rebuild(received);
  charts.rebuild();
  gains.rebuild(received);
  log.rebuild(store.events);
  bar.rebuild();
}

function telemetry(received: Parameters<Store["ingest"]>[0]): void {
  if (!store.ingest(received)) return;
  if (received.reset) world?.clear();
  world?.update(received);
}

function connection(connected: boolean, retryMs: number): void {
  retryAt = connected ? 0 : clockMs() + retryMs;
}

function frame(now: number): void {
  world?.render();
  charts.frame(now);
  if (now - readingsAt >= READINGS_EVERY_MS) {
    readingsAt = now;
    readings();
  }
  requestAnimationFrame(frame);
}

/** Link health: stale data is greyed, and the banner says why. */
function readings(): void {
  const flying = store.state?.phase === "flying";
  const stale = link.health.stale(clockMs(), flying);
  document.body.dataset["stale"] = String(stale);
  bar.readings(stale);
  setText(byId("hand-reading"), handReading(store));
  const banner = byId("link-banner");
  banner.hidden = !stale;
  if (!stale) return;
  const wait = Math.max(0, (retryAt - clockMs()) / 1000);
  const trying = wait > 0 ? `trying again in ${wait.toFixed(0)} s` : "connecting";
  setText(banner, link.health.connected ? "No data from the server. What you see is old." : `No connection to the server: ${trying}.${store.hello === null ? "" : " What you see is old."}`);
}
