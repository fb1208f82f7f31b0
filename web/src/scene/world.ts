// The 3-D view: builds the scene that hello describes, interpolates between telemetry frames, and draws only after a change. While
// the flight is paused it shows the newest frame exactly.
import { Vector3 } from "three";
import { POSE_FLOATS } from "../data/pose";
import type { Telemetry } from "../link/decode";
import type { Palette } from "../panels/theme";
import type { ClientMessage, Hello } from "../protocol";
import { Bodies, type Body } from "./bodies";
import { Camera, type CameraMode } from "./camera";
import { SceneChannels } from "./channels";
import { rimOf } from "./framing";
import { Glide } from "./glide";
import { handOf, HandView } from "./hand";
import { PoseHistory } from "./history";
import { Overlays } from "./overlays";
import { Picker } from "./pick";
import { Pointer, PUSH_LASTS_S } from "./pointer";
import { SPRING_N_PER_M } from "./push";
import { loadSettings, saveSettings, type ViewSettings } from "./settings";
import { buildStage } from "./stage";

const NOTHING = new Float32Array();
const RENDER_SMOOTHING = 0.05;
/** The least time between two pictures without a graphics card, ms. Each picture then takes processor time from charts and gains. */
const SOFTWARE_EVERY_MS = 30;

export interface WorldHandlers {
  /** Called when the operator's dragging has changed the mode of the camera. */
  mode(): void;
  /** Called when another body, or none, was chosen. */
  chosen(): void;
  send(message: ClientMessage): void;
}

export class World {
  readonly view: Camera;
  readonly picker: Picker;
  readonly pointer: Pointer;
  readonly overlays: Overlays;
  readonly history = new PoseHistory();
  readonly settings: ViewSettings = loadSettings();
  bodies: Bodies | null = null;
  channels = new SceneChannels([], 0);
  glide = new Glide(1, this.channels.count);
  /** Contacts of the newest frame. */
  private contacts: Float32Array = NOTHING;
  /** Mean time that the page needs to draw one picture, ms. */
  renderMs = 0;
  /** Number of pictures drawn. */
  pictures = 0;
  private readonly stage;
  private readonly hand: HandView;
  private readonly calm = matchMedia("(prefers-reduced-motion: reduce)");
  private readonly lag = new Vector3();
  private handName: string | undefined;
  private flying = false;
  private old = false;
  private dirty = true;
  /** Whether a frame has arrived to which the bodies have not been moved yet. */
  private unplaced = false;
  private time = NaN;
  private renderedAt = 0;
  private drawnAt = -Infinity;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    handFrame: HTMLElement,
    private palette: Palette,
    private readonly handlers: WorldHandlers,
  ) {
    this.stage = buildStage(canvas);
    const frame = canvas.parentElement ?? canvas;
    this.hand = new HandView(canvas, handFrame);
    this.view = new Camera(canvas, () => this.touch(), () => handlers.mode());
    this.overlays = new Overlays(this.stage.scene, palette, this.settings);
    this.picker = new Picker(this.view.camera, canvas);
    this.pointer = new Pointer(canvas, frame, this.picker, {
      bodies: () => this.bodies,
      hovered: (body) => this.hover(body),
      chosen: (body) => this.choose(body?.name),
      pushed: (force) => this.push(force, PUSH_LASTS_S),
      pushable: () => this.pushable,
    });
    this.stage.setColors(palette);
    new ResizeObserver(() => this.resize(frame.clientWidth, frame.clientHeight)).observe(frame);
  }

  get software(): boolean {
    return this.stage.software;
  }

  get mode(): CameraMode {
    return this.view.mode;
  }

  set mode(mode: CameraMode) {
    this.view.mode = mode;
    this.touch();
  }

  get handShown(): boolean {
    return this.hand.shown;
  }

  set handShown(shown: boolean) {
    this.hand.shown = shown;
    this.touch();
  }

  /** The body whose card is open. */
  get chosenBody(): Body | undefined {
    return this.overlays.chosen.body;
  }

  /** Whether a push has an effect: the flight runs, and the data are not stale. */
  get pushable(): boolean {
    return this.flying && !this.old;
  }

  /** Takes whether the flight runs; a paused flight is shown exactly at its newest frame. */
  flow(flying: boolean): void {
    if (this.flying === flying) return;
    this.flying = flying;
    if (flying) return;
    this.glide.snap();
    this.place();
  }

  /** Takes whether the data are stale; then forces and wind are not drawn, and pushes are off. */
  age(old: boolean): void {
    if (this.old === old) return;
    this.old = old;
    if (old) this.pointer.release();
    this.place();
  }

  /** Shows another flight. */
  rebuild(hello: Hello): void {
    const chosen = this.chosenBody?.name;
    this.bodies?.root.removeFromParent();
    this.bodies?.dispose();
    this.pointer.release();
    this.bodies = new Bodies(hello.scene, this.palette.setpoint, this.palette.muted);
    this.stage.scene.add(this.bodies.root);
    this.channels = new SceneChannels(hello.channels, hello.scene.rotors.length);
    this.glide = new Glide(this.bodies.moving.length + 1, this.channels.count);
    this.overlays.rebuild(hello, this.bodies, this.channels);
    this.clear();
    this.flow(hello.state.phase === "flying");
    this.handName = handOf(hello.scene);
    const vehicle = this.bodies.vehicle()?.object;
    if (vehicle !== undefined) {
      this.view.cover(rimOf(this.bodies.root, vehicle.position));
      this.view.track(vehicle.position);
    }
    this.choose(chosen);
    this.handlers.chosen();
  }

  clear(): void {
    this.overlays.clear();
    this.history.clear();
    this.glide.forget();
    this.contacts = NOTHING;
    this.time = NaN;
    this.touch();
  }

  update(frame: Telemetry): void {
    if (this.bodies === null) return;
    const { target } = this.glide;
    const reference = this.bodies.moving.length * POSE_FLOATS;
    const vehicle = (this.bodies.vehicle()?.index ?? 0) * POSE_FLOATS;
    if (frame.tSim < this.time) this.clear();
    // The trail gets the frame before this one; the end of the trail is the shown position of the vehicle.
    if (!Number.isNaN(this.time)) this.overlays.remember(target, vehicle, reference, this.time);
    target.set(frame.poses.subarray(0, reference));
    target.set(frame.reference, reference);
    this.channels.pick(frame, target, reference + POSE_FLOATS);
    if (Number.isNaN(this.time)) this.overlays.remember(target, vehicle, reference, frame.tSim);
    this.time = frame.tSim;
    this.history.add(frame.tSim, frame.poses);
    this.contacts = frame.contacts;
    this.overlays.contacts.update(frame.contacts);
    this.glide.arrived(performance.now(), !this.flying);
    // While the flight runs the bodies are moved when a picture is drawn, because there are more frames than pictures.
    if (this.flying) this.unplaced = true;
    else this.place();
  }

  /** Shows `frame` at the end of another path, whose points `path` hands over. */
  retrace(path: (point: (timeS: number, poses: Float32Array) => void) => void, frame: Telemetry): void {
    if (this.bodies === null) return;
    const reference = this.bodies.moving.length * POSE_FLOATS;
    const vehicle = (this.bodies.vehicle()?.index ?? 0) * POSE_FLOATS;
    this.clear();
    path((timeS, poses) => {
      this.overlays.remember(poses, vehicle, reference, timeS);
      this.history.add(timeS, poses);
    });
    this.update(frame);
  }

  /** Hides all bodies while the page has no picture of the shown moment. */
  conceal(hidden: boolean): void {
    if (this.bodies === null || this.bodies.root.visible === !hidden) return;
    this.bodies.root.visible = !hidden;
    if (hidden) this.clear();
  }

  recolor(palette: Palette): void {
    this.palette = palette;
    this.stage.setColors(palette);
    this.overlays.recolor(palette);
    this.bodies?.recolor(palette.muted);
    this.touch();
  }

  /** Shows and saves changed settings. */
  applySettings(): void {
    saveSettings(this.settings);
    this.overlays.apply();
    this.place();
  }

  /** Chooses the body called `name`, or none. */
  choose(name: string | undefined): void {
    if (this.overlays.chosen.surround(this.bodies?.body(name))) this.handlers.chosen();
    this.touch();
  }

  /** Chooses the next body (`by` is 1) or the one before (`by` is -1). */
  chooseNext(by: number): void {
    const bodies = this.bodies?.list() ?? [];
    const now = bodies.findIndex(({ name }) => name === this.chosenBody?.name);
    const next = now < 0 && by < 0 ? bodies.length - 1 : (now + by + bodies.length) % bodies.length;
    this.choose(bodies[next]?.name);
  }

  /** Pushes the vehicle by `force`, N in the world, for `duration` s. */
  push(force: Vector3, duration: number): void {
    this.handlers.send({ type: "disturb", disturbance: { kind: "push", force_n: [force.x, force.y, force.z], duration_s: duration } });
  }

  /** Newest forces on the vehicle, N; NaN if they are unknown or stale. */
  forcesNow(): { total_thrust: number; estimate: number; adapter: number } {
    const k = this.scalarsAt;
    const { estimateAt, adapterAt } = this.channels;
    let total = 0;
    for (let i = k; i < k + estimateAt; i += 1) total += this.newest(i);
    return { total_thrust: estimateAt === 0 ? NaN : total, estimate: Math.hypot(...this.triple(k + estimateAt)), adapter: Math.hypot(...this.triple(k + adapterAt)) };
  }

  /** Newest wind at the vehicle in the world, m/s; NaN if it is unknown or stale. */
  windNow(): [number, number, number] {
    return this.triple(this.scalarsAt + this.channels.windAt);
  }

  /** Contacts of the newest frame; empty if the data are stale. */
  get contactsInSight(): Float32Array {
    return this.old ? NOTHING : this.contacts;
  }

  /** Draws if anything changed since the last call. */
  render(now: number): void {
    const { renderer, scene, surface } = this.stage;
    const turned = this.view.advance(now);
    if (this.pointer.frame(now) || turned) this.touch();
    if (!surface.ready() || (this.software && now - this.drawnAt < SOFTWARE_EVERY_MS)) return;
    if (this.glide.sample(now) || this.unplaced) this.place();
    this.overlays.pull(this.pointer.pushing ? this.pointer.spring : null, SPRING_N_PER_M);
    this.spin((now - this.renderedAt) / 1000);
    this.renderedAt = now;
    if (!this.dirty) return;
    this.dirty = false;
    this.drawnAt = now;
    const start = performance.now();
    this.overlays.seenFrom(this.view.camera.position);
    renderer.render(scene, this.view.camera);
    this.hand.render(renderer, scene, this.bodies?.body(this.handName)?.object, this.bodies?.vehicle()?.object);
    surface.finish();
    this.pictures += 1;
    this.renderMs += RENDER_SMOOTHING * (performance.now() - start - this.renderMs);
  }

  private touch(): void {
    this.dirty = true;
  }

  private hover(body: Body | undefined): void {
    if (this.overlays.hovered.surround(body)) this.touch();
    this.canvas.style.cursor = body === undefined ? "" : "pointer";
  }

  private spin(dt: number): void {
    const turning = this.flying && !this.old && !this.calm.matches;
    this.bodies?.rotors.turn(turning ? dt : 0, this.glide.shown, this.scalarsAt);
    if (turning) this.touch();
  }

  private newest(index: number): number {
    return this.old || Number.isNaN(this.time) ? NaN : (this.glide.target[index] ?? NaN);
  }

  private triple(index: number): [number, number, number] {
    return [this.newest(index), this.newest(index + 1), this.newest(index + 2)];
  }

  /** Index of the first single number among the interpolated values. */
  get scalarsAt(): number {
    return ((this.bodies?.moving.length ?? 0) + 1) * POSE_FLOATS;
  }

  /** Moves bodies and overlays to their interpolated poses. */
  private place(): void {
    this.touch();
    this.unplaced = false;
    if (this.bodies === null || Number.isNaN(this.time)) return;
    const { shown, target } = this.glide;
    this.bodies.update(shown, this.settings.shown.ghost);
    const vehicle = this.bodies.vehicle();
    if (vehicle !== undefined) {
      // Contacts belong to the newest frame, but the bodies are shown a little earlier, so contacts are moved with the vehicle.
      const k = vehicle.index * POSE_FLOATS;
      this.lag.set((shown[k] ?? NaN) - (target[k] ?? NaN), (shown[k + 1] ?? NaN) - (target[k + 1] ?? NaN), (shown[k + 2] ?? NaN) - (target[k + 2] ?? NaN));
      if (Number.isFinite(this.lag.x)) this.overlays.contacts.root.position.copy(this.lag);
      this.view.track(vehicle.object.position);
    }
    this.overlays.place(this.bodies, shown, this.scalarsAt, this.time, this.old);
  }

  private resize(width: number, height: number): void {
    if (width === 0 || height === 0) return;
    this.stage.resize(width, height);
    this.overlays.resize(width, height);
    this.view.resize(width / height);
    this.canvas.style.width = "100%";
    this.canvas.style.height = "100%";
    this.touch();
  }
}
