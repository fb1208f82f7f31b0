// The 3-D view: builds what hello describes, follows telemetry, and draws only when something changed.
import { Vector3 } from "three";
import type { Telemetry } from "../link/decode";
import type { Palette } from "../panels/theme";
import type { Hello } from "../protocol";
import { Bodies, type DrawnPose } from "./bodies";
import { Camera, type CameraMode } from "./camera";
import { Contacts } from "./contacts";
import { rimOf } from "./framing";
import { handOf, HandView } from "./hand";
import { Shadow } from "./shadow";
import { buildStage } from "./stage";
import { Trail } from "./trail";

export class World {
  private readonly stage;
  private readonly view: Camera;
  private readonly flown: Trail;
  private readonly wanted: Trail;
  private readonly contacts: Contacts;
  private readonly shadow = new Shadow();
  private readonly hand: HandView;
  private handName: string | undefined;
  private bodies: Bodies | null = null;
  private dirty = true;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    handFrame: HTMLElement,
    private palette: Palette,
    onMode: () => void,
  ) {
    this.stage = buildStage(canvas);
    this.hand = new HandView(canvas, handFrame);
    this.view = new Camera(canvas, () => (this.dirty = true), onMode);
    this.flown = new Trail(palette.estimate);
    this.wanted = new Trail(palette.setpoint);
    this.contacts = new Contacts(palette.fourth);
    this.stage.scene.add(this.wanted.line, this.flown.line, this.contacts.root, this.shadow.mesh);
    this.stage.setColors(palette);
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

  get handShown(): boolean {
    return this.hand.shown;
  }

  set handShown(shown: boolean) {
    this.hand.shown = shown;
    this.dirty = true;
  }

  /** Shows another flight. */
  rebuild(hello: Hello): void {
    if (this.bodies !== null) {
      this.stage.scene.remove(this.bodies.root);
      this.bodies.dispose();
    }
    this.bodies = new Bodies(hello.scene, this.palette.setpoint, this.palette.muted);
    this.stage.scene.add(this.bodies.root);
    this.clear();
    this.handName = handOf(hello.scene);
    const vehicle = this.bodies.vehicle();
    if (vehicle === undefined) return;
    this.view.cover(rimOf(this.bodies.root, vehicle.position));
    this.view.track(vehicle.position);
    this.shadow.follow(vehicle.position);
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
      this.shadow.follow(vehicle.position);
    }
    const [x = NaN, y = NaN, z = NaN] = frame.reference;
    this.wanted.add(x, y, z);
    this.dirty = true;
  }

  recolor(palette: Palette): void {
    this.palette = palette;
    this.stage.setColors(palette);
    this.flown.line.material.color.set(palette.estimate);
    this.wanted.line.material.color.set(palette.setpoint);
    this.contacts.material.color.set(palette.fourth);
    this.bodies?.recolor(palette.muted);
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
    const { renderer, scene } = this.stage;
    renderer.render(scene, this.view.camera);
    this.hand.render(renderer, scene, this.bodies?.body(this.handName), this.bodies?.vehicle());
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
