// The page of a recorded flight, which needs no server: the 3-D view, the charts and the events of the console on one clock.
import { Store } from "../data/store";
import { Beat } from "../panels/beat";
import { cameraButtons } from "../panels/cameraButtons";
import { commands } from "../panels/commands";
import { byId, element, setText } from "../panels/dom";
import { EventLog } from "../panels/events";
import { handReading } from "../panels/handReading";
import { startKeys } from "../panels/keys";
import { notify } from "../panels/notices";
import { SceneView } from "../panels/sceneView";
import { Story } from "../panels/story";
import { startTabs } from "../panels/tabs";
import { readPalette, startTheme } from "../panels/theme";
import { ChartColumn } from "../plots/column";
import { preferProcessorCanvas } from "../plots/software";
import { demandSpec } from "../plots/spec";
import { ScenePlayer } from "../scene/player";
import { World } from "../scene/world";
import { TimeBar } from "../transport/bar";
import { registerTimeKeys } from "../transport/keys";
import { LocalTransport } from "../transport/local";
import { Moment } from "../transport/moment";
import type { Transport } from "../transport/transport";
import { type Flight, type Head, outcome, unpack } from "./flight";
import "../style.css";
import "./replay.css";

const MS_PER_S = 1000;

declare global {
  interface Window {
    /** The values of the page that a browser test may read. */
    __replay?: {
      readonly time: number;
      readonly playing: boolean;
      readonly frames: number;
      readonly failures: number;
      readonly shownPose: number[];
      readonly charts: ReturnType<ChartColumn["shown"]>;
      readonly lanes: TimeBar["shown"];
    };
  }
}

unpack(byId("flight").textContent ?? "").then(start, (error: unknown) => {
  notify("error", `the flight of this page cannot be read: ${error instanceof Error ? error.message : String(error)}`);
});

function start({ head, frames }: Flight): void {
  const store = new Store();
  let world: World | null = null;
  startTheme(byId("theme"), (palette) => {
    world?.recolor(palette);
    charts.recolor();
    timeBar.recolor();
  });
  try {
    world = new World(byId<HTMLCanvasElement>("scene"), byId("hand"), readPalette(), { mode: () => cameras.show(), chosen: () => sceneView?.chosen(), send: () => undefined });
  } catch (error) {
    notify("error", `the 3-D view is off, because this browser has no WebGL 2 (${error instanceof Error ? error.message : "unknown reason"})`);
  }
  if (world?.software ?? true) preferProcessorCanvas();
  const charts = new ChartColumn(store, world?.software ?? true);
  const { view } = charts;
  const log = new EventLog((event) => charts.showEvent(event));
  charts.onCursor = (tick) => log.mark(tick);
  const cameras = cameraButtons(() => world);
  const sceneView = world === null ? null : new SceneView(world, store);
  const local = new LocalTransport(view, { now: () => view.newest(), oldest: () => view.oldest() }, false);
  const transport = (): Transport => local;
  const timeBar = new TimeBar(store, view, transport);
  const moment = new Moment(store, view, new ScenePlayer(store, () => world), () => undefined);
  registerTimeKeys({ bar: timeBar, view, transport, tickS: () => store.tickS, moved: () => charts.speakSoon() });
  startTabs(byId("sections"), "twin.replay.section", (id) => (document.body.dataset["section"] = id));

  store.accept(head.hello);
  world?.rebuild(head.hello);
  sceneView?.rebuild();
  frames.forEach((frame) => store.ingest(frame));
  charts.rebuild();
  charts.showFirst(head.failures.flatMap(({ channels }, k) => demandSpec(channels, head.hello.channels, k) ?? []));
  log.rebuild(store.events);
  timeBar.rebuild();
  describe(head, (time) => local.seek(time));
  const first = head.failures[0];
  const go = (to: number) => (): void => local.step(to - local.timeS);
  commands.register(
    { id: "flight.play", group: "Time", description: "play or stop", keys: ["Space"], action: () => local.toggle() },
    { id: "flight.failure", group: "Time", description: "go to the first failure", keys: ["J"], action: () => go(first?.at_s ?? local.timeS)(), when: () => first !== undefined },
    { id: "camera.overview", group: "Camera", description: "show the whole task", keys: ["F"], action: cameras.overview },
    { id: "camera.follow", group: "Camera", description: "travel beside the vehicle", keys: ["V"], action: cameras.follow },
    { id: "camera.top", group: "Camera", description: "look from above", keys: ["T"], action: cameras.top },
    { id: "camera.hand", group: "Camera", description: "show or hide the close-up of the hand", keys: ["H"], action: cameras.hand },
  );
  startKeys(commands);
  if (first !== undefined) view.markers = head.failures.map(({ at_s }) => at_s);
  view.show(Math.min(view.newest(), Math.max(view.oldest(), head.opens_at_s)));
  const story = new Story(store);
  const texts = new Beat();
  let before = performance.now();
  requestAnimationFrame(frame);
  window.__replay = Object.freeze({
    get time() {
      return local.timeS;
    },
    get playing() {
      return local.playing;
    },
    frames: frames.length,
    failures: head.failures.length,
    get shownPose() {
      return [...(world?.bodies?.vehicle()?.object.position.toArray() ?? [])];
    },
    get charts() {
      return charts.shown();
    },
    get lanes() {
      return timeBar.shown;
    },
  });

  function frame(now: number): void {
    local.frame((now - before) / MS_PER_S);
    before = now;
    // A replay has all ticks from the start, so its playhead always stands somewhere: what leaves the past shows the end.
    if (view.pinned === null) view.show(view.newest());
    const moved = moment.frame(local);
    world?.render(now);
    sceneView?.frame(now);
    charts.frame(now);
    timeBar.frame(now);
    if (moved || texts.due(now)) readings();
    requestAnimationFrame(frame);
  }

  function readings(): void {
    setText(byId("time"), `${local.timeS.toFixed(2)} s`);
    setText(byId("task-phase"), store.phaseText());
    setText(byId("hand-reading"), handReading(store));
    story.readings();
  }
}

/** Shows the name of the flight, its verdict, and the demands that it did not meet. */
function describe(head: Head, seek: (time: number) => void): void {
  document.title = `${head.hello.scenario}: ${head.verdict}`;
  setText(byId("title"), head.hello.scenario);
  byId("title").title = head.title;
  setText(byId("identity"), `flight: ${head.verdict} · seed ${head.seed} · ${head.state_hash} · ${head.program}`);
  byId("identity").title = `${head.reason}; hash of the final state ${head.state_hash}`;
  const badge = byId("verdict");
  setText(badge, outcome(head));
  badge.title = head.reason;
  badge.dataset["tone"] = head.passed === false ? "bad" : head.passed === true ? "good" : "warn";
  const list = byId("failures");
  list.hidden = head.failures.length === 0;
  for (const { at_s, text } of head.failures) {
    const button = element("button", { textContent: `▲ ${at_s.toFixed(2)} s`, title: "Show this moment" });
    button.addEventListener("click", () => seek(at_s));
    list.append(element("li", {}, [button, element("span", { textContent: text })]));
  }
}
