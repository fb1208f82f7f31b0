// The camera: orbits a point, which either stays or travels with the vehicle.
import { Box3, type Object3D, PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

export type CameraMode = "follow" | "orbit";

const FIELD_OF_VIEW_DEG = 45;
/** Where the camera stands from the vehicle at first, m. */
const FIRST_OFFSET = new Vector3(-1.9, -2.0, 1.25);
/** Larger things (a floor, walls) do not count when everything is to be shown, m. */
const FIT_WITHIN_M = 5;

export class Camera {
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 0.02, 200);
  private readonly controls: OrbitControls;
  private readonly followed = new Vector3();
  private known = false;
  private chosen: CameraMode = "follow";

  constructor(element: HTMLElement, onChange: () => void) {
    this.camera.up.set(0, 0, 1);
    this.camera.position.copy(FIRST_OFFSET);
    this.controls = new OrbitControls(this.camera, element);
    this.controls.enableDamping = false;
    this.controls.minDistance = 0.2;
    this.controls.maxDistance = 60;
    this.controls.addEventListener("change", onChange);
    this.controls.update();
  }

  get mode(): CameraMode {
    return this.chosen;
  }

  set mode(mode: CameraMode) {
    if (mode === "follow" && this.known) this.shift(this.followed.clone().sub(this.controls.target));
    this.chosen = mode;
  }

  resize(aspect: number): void {
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
  }

  /** The vehicle is at `position` now. */
  track(position: Vector3): void {
    if (!this.known) this.lookFromStart(position);
    else if (this.chosen === "follow") this.shift(position.clone().sub(this.followed));
    this.followed.copy(position);
    this.known = true;
  }

  /** Another flight: look at its vehicle afresh. */
  forget(): void {
    this.known = false;
  }

  /** Moves back until all of `root` that is not floor or wall is in the picture; looks from where it looked. */
  fit(root: Object3D): void {
    const box = new Box3();
    for (const child of root.children) {
      if (!child.visible) continue;
      const own = new Box3().setFromObject(child);
      const size = own.getSize(new Vector3());
      if (!own.isEmpty() && Math.max(size.x, size.y, size.z) < FIT_WITHIN_M) box.union(own);
    }
    if (box.isEmpty()) return;
    const centre = box.getCenter(new Vector3());
    const radius = Math.max(0.5, box.getSize(new Vector3()).length() / 2);
    const half = (this.camera.fov * Math.PI) / 360;
    const distance = radius / Math.sin(Math.min(half, Math.atan(Math.tan(half) * this.camera.aspect)));
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    this.chosen = "orbit";
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(direction, distance);
    this.controls.update();
  }

  private lookFromStart(position: Vector3): void {
    this.controls.target.copy(position);
    this.camera.position.copy(position).add(FIRST_OFFSET);
    this.controls.update();
  }

  private shift(by: Vector3): void {
    if (by.lengthSq() === 0) return;
    this.controls.target.add(by);
    this.camera.position.add(by);
    this.controls.update();
  }
}
