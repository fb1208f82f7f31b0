// The 3-D view: builds what hello describes, follows telemetry, and draws only when something changed.
import { Vector3 } from "three";
import type { Telemetry } from "../link/decode";
import type { Palette } from "../panels/theme";
import type { Hello } from "../protocol";
import { Bodies, type DrawnPose } from "./bodies";
import { Camera, type CameraMode } from "./camera";
import { Contacts } from "./contacts";
import { buildStage } from "./stage";
import { Trail } from "./trail";

export class World {
  private readonly stage;
  private readonly view: Camera;
  private readonly flown: Trail;
  private readonly wanted: Trail;
  private readonly contacts: Contacts;
  private bodies: Bodies | null = null;
  private dirty = true;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private palette: Palette,
  ) {
    this.stage = buildStage(canvas);
    this.view = new Camera(canvas, () => (this.dirty = true));
    this.flown = new Trail(palette.estimate);
    this.wanted = new Trail(palette.setpoint);
    this.contacts = new Contacts(palette.fourth);
    this.stage.scene.add(this.wanted.line, this.flown.line, this.contacts.root);
    this.stage.setColors(palette.sky, palette.floor);
    const frame = canvas.parentElement ?? canvas;
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
    this.dirty = true;
  }

  /** Shows another flight. */
  rebuild(hello: Hello): void {
    if (this.bodies !== null) {
      this.stage.scene.remove(this.bodies.root);
      this.bodies.dispose();
    }
    this.bodies = new Bodies(hello.scene, this.palette.setpoint, this.palette.third);
    this.stage.scene.add(this.bodies.root);
    this.clear();
    this.view.forget();
    const vehicle = this.bodies.vehicle();
    if (vehicle !== undefined) this.view.track(vehicle.position);
  }

  clear(): void {
    this.flown.clear();
    this.wanted.clear();
    this.contacts.update(new Float32Array());
    this.dirty = true;
  }

  update(frame: Telemetry): void {
    if (this.bodies === null) return;
    this.bodies.update(frame.poses, frame.reference);
    this.contacts.update(frame.contacts);
    const vehicle = this.bodies.vehicle();
    if (vehicle !== undefined) {
      const { x, y, z } = vehicle.position;
      this.flown.add(x, y, z);
      this.view.track(new Vector3(x, y, z));
    }
    const [x = NaN, y = NaN, z = NaN] = frame.reference;
    this.wanted.add(x, y, z);
    this.dirty = true;
  }

  fit(): void {
    if (this.bodies !== null) this.view.fit(this.bodies.root);
    this.dirty = true;
  }

  recolor(palette: Palette): void {
    this.palette = palette;
    this.stage.setColors(palette.sky, palette.floor);
    this.flown.line.material.color.set(palette.estimate);
    this.wanted.line.material.color.set(palette.setpoint);
    this.dirty = true;
  }

  /** World poses as drawn, by body name. */
  drawn(): Record<string, DrawnPose> {
    return this.bodies?.drawn() ?? {};
  }

  /** Draws if anything changed since the last call. */
  render(): void {
    if (!this.dirty) return;
    this.dirty = false;
    this.stage.renderer.render(this.stage.scene, this.view.camera);
  }

  private resize(width: number, height: number): void {
    if (width === 0 || height === 0) return;
    this.stage.renderer.setSize(width, height, false);
    this.view.resize(width / height);
    this.canvas.style.width = "100%";
    this.canvas.style.height = "100%";
    this.dirty = true;
  }
}
