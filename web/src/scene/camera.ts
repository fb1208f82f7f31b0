// The main camera. It stands still and shows the whole task, travels with the vehicle, looks from above, or stays where the
// operator put it. It moves smoothly to its next position, unless the operator has set the system to reduced motion.
import { PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { fitView, isInView } from "./framing";
import { MARKS_LAYER } from "./layers";

export type CameraMode = "overview" | "follow" | "top" | "free";

export const FIELD_OF_VIEW_DEG = 40;
/** Direction from the task to the overview camera: behind the pick and beside the path to the place, so that both fit the picture. */
const OVERVIEW_DIRECTION = new Vector3(-0.62, -0.68, 0.42).normalize();
/** Direction to the camera above, with x to the right and y up in the picture. Exactly above, up would be undefined. */
const TOP_DIRECTION = new Vector3(0, -1e-4, 1).normalize();
/** Offset of the camera that travels beside the vehicle, m. */
const FOLLOW_OFFSET = new Vector3(-1.25, -1.45, 0.7);
/** The camera looks this far below the vehicle, so that the arm and the payload are in the picture too, m. */
const FOLLOW_DROP_M = 0.15;
const MOVE_MS = 450;

export class Camera {
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 0.02, 200);
  private readonly controls: OrbitControls;
  private readonly calm = matchMedia("(prefers-reduced-motion: reduce)");
  private readonly followed = new Vector3();
  private readonly step = new Vector3();
  private readonly goal = { target: new Vector3(), position: new Vector3() };
  private readonly from = { target: new Vector3(), position: new Vector3() };
  private movingSince = NaN;
  private held = false;
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
    // A click without a movement chooses a body and does not change the mode.
    this.controls.addEventListener("start", () => (this.held = true));
    this.controls.addEventListener("end", () => (this.held = false));
    this.controls.addEventListener("change", () => {
      onChange();
      if (!this.held) return;
      this.movingSince = NaN;
      if (this.chosen !== "overview" && this.chosen !== "top") return;
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
    this.go();
  }

  /** Point at which the camera looks, in the world, m. */
  get target(): Vector3 {
    return this.controls.target;
  }

  /** Horizontal direction in which the camera looks, rad from x towards y. */
  get heading(): number {
    return Math.atan2(this.controls.target.y - this.camera.position.y, this.controls.target.x - this.camera.position.x);
  }

  /** Whether the camera is moving to another position. */
  get moving(): boolean {
    return !Number.isNaN(this.movingSince);
  }

  resize(aspect: number): void {
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
    if (this.chosen === "overview" || this.chosen === "top") this.arrive();
  }

  /** Sets the points that the overview must show, in the world, m. */
  cover(points: Vector3[]): void {
    this.points = points;
    this.known = false;
    if (this.chosen === "overview" || this.chosen === "top") this.arrive();
  }

  /** Takes the new `position` of the vehicle, in the world, m. */
  track(position: Vector3): void {
    const first = !this.known;
    this.known = true;
    this.step.copy(position).sub(this.followed);
    this.followed.copy(position);
    if (this.chosen === "follow" && !this.moving) {
      if (first) this.arrive();
      else if (this.step.lengthSq() > 0) {
        this.controls.target.add(this.step);
        this.camera.position.add(this.step);
        this.controls.update();
      }
    } else if ((this.chosen === "overview" || this.chosen === "top") && !this.moving && !isInView(this.camera, position)) {
      this.points.push(position.clone());
      this.go();
    }
  }

  /** Moves the camera on towards the goal of its mode; returns true while it moves. `now` is the time in ms. */
  advance(now: number): boolean {
    if (!this.moving || !this.setGoal()) return false;
    const share = Math.min(1, (now - this.movingSince) / MOVE_MS);
    const eased = share * share * (3 - 2 * share);
    this.controls.target.lerpVectors(this.from.target, this.goal.target, eased);
    this.camera.position.lerpVectors(this.from.position, this.goal.position, eased);
    if (share >= 1) this.movingSince = NaN;
    this.controls.update();
    return true;
  }

  private go(): void {
    if (this.calm.matches) return this.arrive();
    if (!this.setGoal()) return;
    this.from.target.copy(this.controls.target);
    this.from.position.copy(this.camera.position);
    this.movingSince = performance.now();
  }

  private arrive(): void {
    this.movingSince = NaN;
    if (!this.setGoal()) return;
    this.controls.target.copy(this.goal.target);
    this.camera.position.copy(this.goal.position);
    this.controls.update();
  }

  /** Computes the goal of the mode; returns false if the mode has none. */
  private setGoal(): boolean {
    if (this.chosen === "free" || (this.chosen === "follow" && !this.known)) return false;
    if (this.chosen === "follow") {
      this.goal.target.copy(this.followed);
      this.goal.target.z -= FOLLOW_DROP_M;
      this.goal.position.copy(this.goal.target).add(FOLLOW_OFFSET);
      return true;
    }
    if (this.points.length === 0) return false;
    const { target, position } = fitView(this.points, this.chosen === "top" ? TOP_DIRECTION : OVERVIEW_DIRECTION, this.camera);
    this.goal.target.copy(target);
    this.goal.position.copy(position);
    return true;
  }
}
