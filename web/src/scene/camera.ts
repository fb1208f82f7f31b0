// The main camera: stands still and shows the whole task, travels with the vehicle, or stays where the operator put it.
import { PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { fitView, isInView } from "./framing";
import { MARKS_LAYER } from "./layers";

export type CameraMode = "overview" | "follow" | "free";

const FIELD_OF_VIEW_DEG = 40;
/** From where the overview looks: behind the pick, beside the way to the place, so that near and far fit one picture. */
const OVERVIEW_DIRECTION = new Vector3(-0.62, -0.68, 0.42).normalize();
/** Where the camera travels beside the vehicle, m. */
const FOLLOW_OFFSET = new Vector3(-1.25, -1.45, 0.7);
/** What hangs under the vehicle counts as much as the vehicle, m. */
const FOLLOW_DROP_M = 0.15;

export class Camera {
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 0.02, 200);
  private readonly controls: OrbitControls;
  private readonly followed = new Vector3();
  private known = false;
  private chosen: CameraMode = "overview";
  private points: Vector3[] = [];

  constructor(element: HTMLElement, onChange: () => void, onMode: () => void) {
    this.camera.up.set(0, 0, 1);
    this.camera.layers.enable(MARKS_LAYER);
    this.camera.position.copy(OVERVIEW_DIRECTION).multiplyScalar(5);
    this.controls = new OrbitControls(this.camera, element);
    this.controls.enableDamping = false;
    this.controls.minDistance = 0.2;
    this.controls.maxDistance = 60;
    this.controls.addEventListener("change", onChange);
    this.controls.addEventListener("start", () => {
      if (this.chosen !== "overview") return;
      this.chosen = "free";
      onMode();
    });
    this.controls.update();
  }

  get mode(): CameraMode {
    return this.chosen;
  }

  set mode(mode: CameraMode) {
    this.chosen = mode;
    if (mode === "overview") this.frame();
    if (mode === "follow" && this.known) this.standBeside();
  }

  resize(aspect: number): void {
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
    if (this.chosen === "overview") this.frame();
  }

  /** What the overview is to show: points at its rim, world frame, m. */
  cover(points: Vector3[]): void {
    this.points = points;
    this.known = false;
    if (this.chosen === "overview") this.frame();
  }

  /** The vehicle is at `position` now. */
  track(position: Vector3): void {
    if (this.chosen === "follow") {
      if (this.known) this.shift(position.clone().sub(this.followed));
      else this.standBeside(position);
    } else if (this.chosen === "overview" && !isInView(this.camera, position)) {
      this.points.push(position.clone());
      this.frame();
    }
    this.followed.copy(position);
    this.known = true;
  }

  private standBeside(position = this.followed): void {
    this.controls.target.copy(position);
    this.controls.target.z -= FOLLOW_DROP_M;
    this.camera.position.copy(this.controls.target).add(FOLLOW_OFFSET);
    this.controls.update();
  }

  private frame(): void {
    if (this.points.length === 0) return;
    const { target, position } = fitView(this.points, OVERVIEW_DIRECTION, this.camera);
    this.controls.target.copy(target);
    this.camera.position.copy(position);
    this.controls.update();
  }

  private shift(by: Vector3): void {
    if (by.lengthSq() === 0) return;
    this.controls.target.add(by);
    this.camera.position.add(by);
    this.controls.update();
  }
}
