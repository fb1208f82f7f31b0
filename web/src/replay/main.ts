// The page of a recorded flight, which needs no server: the 3-D view, the charts and the events of the console on one clock.
import { Store } from "../data/store";
import { cameraButtons } from "../panels/cameraButtons";
import { commands } from "../panels/commands";
import { byId, element, setText } from "../panels/dom";
import { EventLog } from "../panels/events";
import { handReading } from "../panels/handReading";
import { startKeys } from "../panels/keys";
import { notify } from "../panels/notices";
import { SceneView } from "../panels/sceneView";
import { readPalette, startTheme } from "../panels/theme";
import { ChartColumn } from "../plots/column";
import { preferProcessorCanvas } from "../plots/software";
import { World } from "../scene/world";
import { type Flight, type Head, unpack } from "./flight";
import { Player } from "./player";
import "../style.css";
import "./replay.css";

declare global {
  interface Window {
    /** The values of the page that a browser test may read. */
    __replay?: { readonly time: number; readonly playing: boolean; readonly frames: number; readonly failures: number; readonly shownPose: number[] };
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
  });
  try {
    world = new World(byId<HTMLCanvasElement>("scene"), byId("hand"), readPalette(), { mode: () => cameras.show(), chosen: () => view?.chosen(), send: () => undefined });
  } catch (error) {
    notify("error", `the 3-D view is off, because this browser has no WebGL 2 (${error instanceof Error ? error.message : "unknown reason"})`);
  }
  if (world?.software ?? true) preferProcessorCanvas();
  const charts = new ChartColumn(store, world?.software ?? true);
  const log = new EventLog((event) => charts.showEvent(event));
  charts.onCursor = (tick) => log.mark(tick);
  const cameras = cameraButtons(() => world);
  const view = world === null ? null : new SceneView(world, store);
  const player = new Player(frames, () => world);

  store.accept(head.hello);
  world?.rebuild(head.hello);
  view?.rebuild();
  frames.forEach((frame) => store.ingest(frame));
  charts.rebuild();
  log.rebuild(store.events);
  describe(head, (time) => seek(time));

  let time = Math.min(player.endS, Math.max(player.startS, head.opens_at_s));
  const scrub = byId<HTMLInputElement>("scrub");
  Object.assign(scrub, { min: String(player.startS), max: String(player.endS), step: String(store.tickS) });
  scrub.addEventListener("input", () => seek(Number(scrub.value)));
  const speed = byId<HTMLSelectElement>("speed");
  speed.addEventListener("change", () => (player.speed = Number(speed.value)));
  const play = (): void => seek(player.toggle(time));
  byId("play").addEventListener("click", play);
  const go = (to: number) => (): void => {
    player.playing = false;
    seek(to);
  };
  const first = head.failures[0];
  commands.register(
    { id: "flight.play", group: "Flight", description: "play or stop", keys: ["Space"], action: play },
    { id: "flight.start", group: "Flight", description: "go to the start", keys: ["Ctrl+Home"], action: go(player.startS) },
    { id: "flight.failure", group: "Flight", description: "go to the first failure", keys: ["J"], action: () => go(first?.at_s ?? time)(), when: () => first !== undefined },
    { id: "camera.overview", group: "Camera", description: "show the whole task", keys: ["F"], action: cameras.overview },
    { id: "camera.follow", group: "Camera", description: "travel beside the vehicle", keys: ["V"], action: cameras.follow },
    { id: "camera.top", group: "Camera", description: "look from above", keys: ["T"], action: cameras.top },
    { id: "camera.hand", group: "Camera", description: "show or hide the close-up of the hand", keys: ["H"], action: cameras.hand },
  );
  startKeys(commands);
  if (first !== undefined) charts.view.markers = head.failures.map(({ at_s }) => at_s);
  charts.view.show(time);
  let before = performance.now();
  requestAnimationFrame(frame);
  window.__replay = Object.freeze({
    get time() {
      return time;
    },
    get playing() {
      return player.playing;
    },
    frames: frames.length,
    failures: head.failures.length,
    get shownPose() {
      return [...(world?.bodies?.vehicle()?.object.position.toArray() ?? [])];
    },
  });

  function seek(to: number): void {
    time = to;
    charts.view.moveCursor(to);
  }

  function frame(now: number): void {
    const next = player.advance(time, (now - before) / 1000);
    before = now;
    if (next !== time) seek(next);
    const { pinned } = charts.view;
    // Without a cursor the charts would follow the newest tick, but a replay has all ticks from the start.
    if (pinned === null) charts.view.show(time);
    else time = Math.min(player.endS, Math.max(player.startS, pinned));
    player.show(time);
    world?.render(now);
    view?.frame(now);
    charts.frame(now);
    readings();
    requestAnimationFrame(frame);
  }

  function readings(): void {
    if (document.activeElement !== scrub || player.playing) scrub.value = String(time);
    setText(byId("time"), `${time.toFixed(2)} s`);
    setText(byId("play"), player.playing ? "❚❚ Stop" : "▶ Play");
    const at = store.events.filter(({ kind, t_s }) => kind === "phase" && t_s <= time + 1e-6).at(-1);
    setText(byId("task-phase"), at?.text ?? "");
    const shown = { latest: (name: string) => store.at(name, store.tickAt(time)) };
    setText(byId("hand-reading"), handReading(shown));
  }
}

/** Shows the name of the flight, its verdict, and the demands that it did not meet. */
function describe(head: Head, seek: (time: number) => void): void {
  document.title = `${head.hello.scenario}: ${head.verdict}`;
  setText(byId("title"), head.hello.scenario);
  byId("title").title = head.title;
  setText(byId("identity"), `seed ${head.seed} · ${head.state_hash} · ${head.program}`);
  const badge = byId("verdict");
  setText(badge, head.verdict);
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
