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
import { Story } from "./panels/story";
import { readPalette, startTheme } from "./panels/theme";
import { TopBar } from "./panels/topbar";
import { Workbench } from "./panels/workbench";
import { ChartColumn } from "./plots/column";
import { preferProcessorCanvas } from "./plots/software";
import { type MirrorInfo, PROTOCOL_VERSION, type ServerMessage } from "./protocol";
import { ScenePlayer } from "./scene/player";
import { World } from "./scene/world";
import { TimeBar } from "./transport/bar";
import { registerTimeKeys } from "./transport/keys";
import { LocalTransport } from "./transport/local";
import { MirrorTransport } from "./transport/mirror";
import { Moment } from "./transport/moment";
import type { Transport } from "./transport/transport";

const MS_PER_S = 1000;
/** Time between two checks whether the data are stale, ms. */
const AGE_EVERY_MS = 100;

const store = new Store();
const link = new Link({ message, telemetry, unreadable: (text) => notify("error", text), connection });
startTheme(byId("theme"), (palette) => {
  world?.recolor(palette);
  charts.recolor();
  timeBar.recolor();
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
// On a phone the whole task leaves the vehicle so small that the table hides it.
if (matchMedia("(max-width: 480px)").matches) cameras.follow();
/** File of the mirrored recording on the screen; null if there is none. */
let shownFile: string | null = null;
const sceneView = world === null ? null : new SceneView(world, store);
const { view } = charts;
const local = new LocalTransport(view, { now: () => view.newest(), oldest: () => view.oldest() }, true);
/** Plays the mirrored recording; null while a simulated vehicle flies. */
let recorded: MirrorTransport | null = null;
const transport = (): Transport => recorded ?? local;
const timeBar = new TimeBar(store, view, transport);
const moment = new Moment(store, view, new ScenePlayer(store, () => world), (past) => enter(past));
registerTimeKeys({ bar: timeBar, view, transport, tickS: () => store.tickS, moved: () => charts.speakSoon() });
commands.register(
  { id: "flight.pause", group: "Flight", description: "pause or continue", keys: ["Space"], action: () => bar.togglePause(), when: () => !local.past || recorded !== null },
  { id: "flight.pauseNow", group: "Flight", description: "pause or continue the flight, also while the page shows the past", keys: ["Shift+Space"], action: () => bar.togglePause() },
  { id: "flight.tick", group: "Flight", description: "fly one tick", keys: ["Ctrl+ArrowRight"], action: () => bar.step(), when: onLine, repeats: true },
  { id: "flight.on", group: "Flight", description: "fly 100 ms while paused", keys: ["ArrowRight"], action: () => bar.step(Math.round(0.1 / (store.hello?.tick_s ?? 0.01))), when: () => store.state?.phase === "paused" && onLine(), repeats: true },
  { id: "flight.restart", group: "Flight", description: "restart the flight", keys: ["R"], action: () => bar.restart() },
  { id: "camera.overview", group: "Camera", description: "show the whole task", keys: ["F"], action: cameras.overview },
  { id: "camera.follow", group: "Camera", description: "travel beside the vehicle", keys: ["V"], action: cameras.follow },
  { id: "camera.top", group: "Camera", description: "look from above", keys: ["T"], action: cameras.top },
  { id: "camera.hand", group: "Camera", description: "show or hide the close-up of the hand", keys: ["H"], action: cameras.hand },
);
const bench = new Workbench(store, link, bar, () => (store.playhead === null ? null : store.timeOf(store.playhead)));
const mirror = new MirrorBar(store);
const { gains } = bench;
startKeys(commands);
installHooks(store, link, gains, charts, () => world, () => ({ transport: transport(), bar: timeBar }));
const story = new Story(store);
let retryAt = 0;
let ageAt = 0;
let frameAt = performance.now();
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
      world?.flow(received.phase === "flying" && !moment.isPast);
      bench.show();
      return bar.show();
    case "gain":
      store.forgetDrawn();
      return gains.echo(received);
    case "gains":
      store.forgetDrawn();
      return gains.replace(received);
    case "events":
      log.add(store.addEvents(received.events));
      return bar.show();
    case "forks":
      store.forks.update(received.forks);
      return bench.forks.update(received.forks);
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
  recorded = transportOf(received.mirror);
  view.remote = recorded === null ? null : (time) => recorded?.seek(time);
  recordingBanner.update(received.state.recording);
  world?.rebuild(received);
  sceneView?.rebuild();
  charts.rebuild();
  bench.rebuild(received);
  log.rebuild(store.events);
  bar.rebuild();
  mirror.rebuild();
  timeBar.rebuild();
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
  if (moment.isPast) return;
  if (received.reset) world?.clear();
  world?.update(received);
}

/** The transport of a recording that is mirrored; a jump within the same recording keeps it. */
function transportOf(info: MirrorInfo | null): MirrorTransport | null {
  if (info === null) return null;
  if (recorded === null || shownFile !== info.file) return new MirrorTransport(store, info, (request) => link.send(request), () => view.marked());
  recorded.arrived(info);
  return recorded;
}

/** Shows that the page entered or left the past. */
function enter(past: boolean): void {
  document.body.dataset["when"] = past ? "past" : "now";
  world?.flow(!past && store.state?.phase === "flying");
  world?.age(stale && !past);
  bar.show();
}

/** Whether the page shows the newest moment of a simulated flight, which the keys to the right then fly on. */
function onLine(): boolean {
  return recorded === null && !local.past;
}

function connection(connected: boolean, retryMs: number): void {
  retryAt = connected ? 0 : clockMs() + retryMs;
}

function frame(now: number): void {
  transport().frame((now - frameAt) / MS_PER_S);
  frameAt = now;
  if (moment.frame(transport())) bar.show();
  const drawn = world?.pictures;
  world?.render(performance.now());
  if (world?.pictures !== drawn) bench.drawn(now);
  timeBar.frame(now);
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
  world?.age(stale && !moment.isPast);
  readings();
}

/** Writes the texts that change all the time, and the banner that says why data are stale. */
function readings(): void {
  bar.readings(stale);
  mirror.readings();
  log.markGone(store.history.first);
  bench.readings(stale);
  setText(byId("hand-reading"), handReading(store));
  story.readings();
  const banner = byId("link-banner");
  banner.hidden = !stale;
  if (!stale) return;
  const wait = Math.max(0, (retryAt - clockMs()) / 1000);
  const trying = wait > 0 ? `trying again in ${wait.toFixed(0)} s` : "connecting";
  setText(banner, link.health.connected ? "No data from the server. What you see is old." : `No connection to the server: ${trying}.${store.hello === null ? "" : " What you see is old."}`);
}
