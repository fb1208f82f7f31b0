// The console: one link feeds one store, three views show the store, and one loop draws the frames. `commands` lists all actions.
import { handReading } from "./panels/handReading";
import { Store } from "./data/store";
import { installHooks } from "./hooks";
import { clockMs, Link } from "./link/link";
import { Beat } from "./panels/beat";
import { cameraButtons } from "./panels/cameraButtons";
import { commands } from "./panels/commands";
import { byId, setText } from "./panels/dom";
import { EventLog } from "./panels/events";
import { startKeys } from "./panels/keys";
import { MirrorBar } from "./panels/mirrorBar";
import { notify } from "./panels/notices";
import { RecordingBanner } from "./panels/recordingBanner";
import { SceneView } from "./panels/sceneView";
import { readPalette, startTheme } from "./panels/theme";
import { TopBar } from "./panels/topbar";
import { Workbench } from "./panels/workbench";
import { ChartColumn } from "./plots/column";
import { preferProcessorCanvas } from "./plots/software";
import { PROTOCOL_VERSION, type ServerMessage } from "./protocol";
import { World } from "./scene/world";

/** Time between two checks whether the data are stale, ms. */
const AGE_EVERY_MS = 100;

const store = new Store();
const link = new Link({ message, telemetry, unreadable: (text) => notify("error", text), connection });
startTheme(byId("theme"), (palette) => {
  world?.recolor(palette);
  charts.recolor();
});
const palette = readPalette();
const world = buildWorld();
if (world?.software ?? true) preferProcessorCanvas();
const charts = new ChartColumn(store, world?.software ?? true);
const log = new EventLog((event) => charts.showEvent(event));
charts.onCursor = (tick) => log.mark(tick);
const bar = new TopBar(store, link);
const recordingBanner = new RecordingBanner();
const cameras = cameraButtons(() => world);
/** File of the mirrored recording on the screen; null if there is none. */
let shownFile: string | null = null;
const sceneView = world === null ? null : new SceneView(world, store);
commands.register(
  { id: "flight.pause", group: "Flight", description: "pause or continue", keys: ["Space"], action: () => bar.togglePause() },
  { id: "flight.tick", group: "Flight", description: "fly one tick", keys: ["Ctrl+ArrowRight"], action: () => bar.step(), when: () => !charts.view.inspecting, repeats: true },
  { id: "flight.on", group: "Flight", description: "fly 100 ms while paused", keys: ["ArrowRight"], action: () => bar.step(Math.round(0.1 / (store.hello?.tick_s ?? 0.01))), when: () => store.state?.phase === "paused" && !charts.view.inspecting, repeats: true },
  { id: "flight.restart", group: "Flight", description: "restart the flight", keys: ["R"], action: () => bar.restart() },
  { id: "camera.overview", group: "Camera", description: "show the whole task", keys: ["F"], action: cameras.overview },
  { id: "camera.follow", group: "Camera", description: "travel beside the vehicle", keys: ["V"], action: cameras.follow },
  { id: "camera.top", group: "Camera", description: "look from above", keys: ["T"], action: cameras.top },
  { id: "camera.hand", group: "Camera", description: "show or hide the close-up of the hand", keys: ["H"], action: cameras.hand },
);
const bench = new Workbench(store, link, bar);
const mirror = new MirrorBar(store, (request) => link.send(request), () => charts.view.marked());
const { gains } = bench;
startKeys(commands);
installHooks(store, link, gains, charts, () => world);
let retryAt = 0;
let ageAt = 0;
const texts = new Beat();
let stale = false;
/** Whether the last check found the data stale. */
let suspect = false;
const address = new URL("/ws", location.href);
address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
link.open(address.href);
requestAnimationFrame(frame);

function buildWorld(): World | null {
  try {
    return new World(byId<HTMLCanvasElement>("scene"), byId("hand"), palette, {
      mode: () => cameras.show(),
      chosen: () => sceneView?.chosen(),
      send: (request) => link.send(request),
    });
  } catch (error) {
    notify("error", `the 3-D view is off, because this browser has no WebGL 2 (${error instanceof Error ? error.message : "unknown reason"}); charts and gains work without it`);
    return null;
  }
}

function message(received: ServerMessage): void {
  switch (received.type) {
    case "hello":
      return hello(received);
    case "state":
      store.state = received;
      recordingBanner.update(received.recording);
      world?.flow(received.phase === "flying");
      bench.show();
      return bar.show();
    case "gain":
      store.forgetDrawn();
      return gains.echo(received);
    case "gains":
      store.forgetDrawn();
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
      charts.clear();
      return log.rebuild([]);
    case "pong":
  }
}

function hello(received: Extract<ServerMessage, { type: "hello" }>): void {
  if (received.protocol !== PROTOCOL_VERSION) {
    notify("error", `the server uses protocol ${received.protocol} and this page ${PROTOCOL_VERSION}: reload the page`);
    return;
  }
  store.accept(received);
  recordingBanner.update(received.state.recording);
  world?.rebuild(received);
  sceneView?.rebuild();
  charts.rebuild();
  bench.rebuild(received);
  log.rebuild(store.events);
  bar.rebuild();
  mirror.rebuild();
  followed(received.mirror?.file ?? null);
}

/** Lets the camera follow the vehicle of a new recording, because a recorded flight has no arena that the camera could show. */
function followed(file: string | null): void {
  if (file !== null && file !== shownFile) cameras.follow();
  shownFile = file;
}

function telemetry(received: Parameters<Store["ingest"]>[0]): void {
  if (!store.ingest(received)) return;
  if (received.gap > 0) bench.loss.lost(received.gap);
  if (received.reset) world?.clear();
  world?.update(received);
}

function connection(connected: boolean, retryMs: number): void {
  retryAt = connected ? 0 : clockMs() + retryMs;
}

function frame(now: number): void {
  bench.frame(now);
  world?.render(performance.now());
  sceneView?.frame(now);
  charts.frame(now);
  if (now - ageAt >= AGE_EVERY_MS) {
    ageAt = now;
    age();
  }
  if (texts.due(now)) readings();
  requestAnimationFrame(frame);
}

/**
 * Greys the page while data are stale. While the connection is open, two checks in a row must find them stale: a page that was busy
 * for long adds the waiting frames between two checks.
 */
function age(): void {
  const old = link.health.stale(clockMs(), store.state?.phase === "flying");
  const found = old && (suspect || !link.health.connected);
  suspect = old;
  if (found === stale && document.body.dataset["stale"] !== undefined) return;
  stale = found;
  document.body.dataset["stale"] = String(stale);
  world?.age(stale);
  readings();
}

/** Writes the texts that change all the time, and the banner that says why data are stale. */
function readings(): void {
  bar.readings(stale);
  mirror.readings();
  log.markGone(store.history.first);
  bench.readings(stale);
  setText(byId("hand-reading"), handReading(store));
  const banner = byId("link-banner");
  banner.hidden = !stale;
  if (!stale) return;
  const wait = Math.max(0, (retryAt - clockMs()) / 1000);
  const trying = wait > 0 ? `trying again in ${wait.toFixed(0)} s` : "connecting";
  setText(banner, link.health.connected ? "No data from the server. What you see is old." : `No connection to the server: ${trying}.${store.hello === null ? "" : " What you see is old."}`);
}
