// The close-up of the hand: a second camera that stays in front of the fingers, drawn into a corner of the view.
import { type Object3D, PerspectiveCamera, Vector3, type WebGLRenderer, type Scene as ThreeScene } from "three";
import type { Scene } from "../protocol";

/** Patterns for the names of the grasp point or the hand in vehicle descriptions, most exact first. */
const NAMED = [/tool|tcp/i, /palm|hand|gripper/i];
/** Offset of the camera from the hand, in the heading of the vehicle, m. The fingers open sideways, so it stands mostly ahead. */
const OFFSET = new Vector3(0.42, -0.3, 0.14);
const FIELD_OF_VIEW_DEG = 34;
const UP = new Vector3(0, 0, 1);

/** Name of the body that is the vehicle's hand; undefined for a vehicle without a hand. */
export function handOf(scene: Scene): string | undefined {
  const links = scene.bodies.filter(({ group, moving, name }) => group === "vehicle" && moving && name !== scene.base_body);
  for (const pattern of NAMED) {
    const found = links.find(({ name }) => pattern.test(name));
    if (found !== undefined) return found.name;
  }
  return links.at(-1)?.name;
}

export class HandView {
  /** On a phone the close-up would hide the vehicle, so it is shown on request. */
  shown = !matchMedia("(max-width: 480px)").matches;
  private readonly camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 0.02, 20);
  private readonly place = new Vector3();
  private readonly heading = new Vector3();

  /** `frame` is the element that shows the picture; it lies over `canvas`. */
  constructor(
    private readonly canvas: HTMLElement,
    private readonly frame: HTMLElement,
  ) {
    this.camera.up.copy(UP);
  }

  /** Draws the close-up over the picture that `renderer` has drawn already. */
  render(renderer: WebGLRenderer, scene: ThreeScene, hand: Object3D | undefined, base: Object3D | undefined): void {
    const shown = this.shown && hand !== undefined && base !== undefined;
    this.frame.hidden = !shown;
    if (!shown) return;
    const outer = this.canvas.getBoundingClientRect();
    const inner = this.frame.getBoundingClientRect();
    const [left, bottom] = [inner.left - outer.left, outer.bottom - inner.bottom];
    this.look(hand, base, inner.width / inner.height);
    renderer.setScissorTest(true);
    renderer.setScissor(left, bottom, inner.width, inner.height);
    renderer.setViewport(left, bottom, inner.width, inner.height);
    renderer.render(scene, this.camera);
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, outer.width, outer.height);
  }

  private look(hand: Object3D, base: Object3D, aspect: number): void {
    if (!(aspect > 0)) return;
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
    const ahead = this.heading.set(1, 0, 0).applyQuaternion(base.quaternion);
    const yaw = Math.atan2(ahead.y, ahead.x);
    this.camera.position.copy(hand.position).add(this.place.copy(OFFSET).applyAxisAngle(UP, yaw));
    this.camera.lookAt(hand.position);
  }
}
