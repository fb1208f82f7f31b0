// The mouse on the 3-D view: hovering marks a body, a click chooses it, and Ctrl+drag on the vehicle pushes it. OrbitControls turns
// the camera and gets no events of a push.
import { Vector2, Vector3 } from "three";
import type { Bodies, Body } from "./bodies";
import { Picker } from "./pick";
import { PushSpring } from "./push";

/** During a drag a push is sent this often, ms. Each push lasts twice as long, so that a late message leaves no gap. */
export const PUSH_EVERY_MS = 50;
export const PUSH_LASTS_S = 0.1;
/** A weaker push is not sent, because the hand only rests, N. */
const FAINTEST_N = 0.2;
const HOVER_EVERY_MS = 100;
/** A press that moves the pointer less than this is a click, px. */
const CLICK_PX = 6;

export interface PointerHandlers {
  bodies(): Bodies | null;
  hovered(body: Body | undefined): void;
  chosen(body: Body | undefined): void;
  /** Pushes the vehicle by `force`, N in the world, for `PUSH_LASTS_S`. */
  pushed(force: Vector3): void;
  /** Whether a push would do anything now. */
  pushable(): boolean;
}

export class Pointer {
  readonly spring = new PushSpring();
  /** Last position of the cursor, page px. */
  readonly cursor = new Vector2(NaN, NaN);
  private readonly ndc = new Vector2();
  private readonly pressedAt = new Vector2(NaN, NaN);
  private readonly grabbedInBody = new Vector3();
  private readonly grabbed = new Vector3();
  private held: Body | undefined;
  private timer = 0;
  private inside = false;
  private hoverAt = -Infinity;

  constructor(
    private readonly canvas: HTMLElement,
    frame: HTMLElement,
    private readonly picker: Picker,
    private readonly handlers: PointerHandlers,
  ) {
    // The capture phase comes before OrbitControls, which listens to the canvas itself.
    frame.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    frame.addEventListener("contextmenu", (event) => event.target === canvas && event.preventDefault());
    canvas.addEventListener("pointerleave", () => this.leave());
    window.addEventListener("pointermove", (event) => this.move(event));
    window.addEventListener("pointerup", (event) => this.up(event));
    window.addEventListener("pointercancel", () => this.release());
    window.addEventListener("blur", () => this.release());
    document.addEventListener("visibilitychange", () => document.hidden && this.release());
  }

  /** Whether the operator is pushing the vehicle. */
  get pushing(): boolean {
    return this.held !== undefined;
  }

  /** Lets go of the vehicle. */
  release(): void {
    window.clearInterval(this.timer);
    this.held = undefined;
    this.canvas.style.cursor = "";
  }

  /** Finds the body under a resting cursor, or moves the spring with the vehicle; returns true during a push. */
  frame(now: number): boolean {
    if (this.held !== undefined) {
      this.pull();
      return true;
    }
    if (this.inside && now - this.hoverAt >= HOVER_EVERY_MS) {
      this.hoverAt = now;
      const bodies = this.handlers.bodies();
      if (bodies !== null) this.handlers.hovered(this.picker.pick(bodies, this.place())?.body);
    }
    return false;
  }

  private down(event: PointerEvent): void {
    if (event.target !== this.canvas || event.button !== 0) return;
    this.cursor.set(event.clientX, event.clientY);
    if (!event.ctrlKey && !event.metaKey) {
      this.pressedAt.copy(this.cursor);
      return;
    }
    event.stopPropagation();
    event.preventDefault();
    const bodies = this.handlers.bodies();
    const hit = bodies === null ? undefined : this.picker.grab(bodies, this.place(), event.clientX, event.clientY);
    if (hit === undefined) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.held = hit.body;
    this.grabbedInBody.copy(hit.point);
    hit.body.object.worldToLocal(this.grabbedInBody);
    this.canvas.style.cursor = "grabbing";
    this.handlers.hovered(undefined);
    this.pull();
    this.timer = window.setInterval(() => this.send(), PUSH_EVERY_MS);
  }

  private move(event: PointerEvent): void {
    this.cursor.set(event.clientX, event.clientY);
    // While a button is pressed the picture turns, and bodies that pass under the cursor are not marked.
    this.inside = event.target === this.canvas && event.buttons === 0 && event.pointerType !== "touch";
  }

  private up(event: PointerEvent): void {
    if (this.held !== undefined) return this.release();
    const pressed = this.pressedAt.distanceTo(this.cursor.set(event.clientX, event.clientY)) < CLICK_PX;
    this.pressedAt.set(NaN, NaN);
    const bodies = this.handlers.bodies();
    if (pressed && bodies !== null && event.target === this.canvas) this.handlers.chosen(this.picker.pick(bodies, this.place())?.body);
  }

  private leave(): void {
    this.inside = false;
    if (!this.pushing) this.handlers.hovered(undefined);
  }

  private place(): Vector2 {
    return this.picker.ndc(this.cursor.x, this.cursor.y, this.ndc);
  }

  private pull(): void {
    if (this.held === undefined) return;
    this.held.object.updateWorldMatrix(true, false);
    this.grabbed.copy(this.grabbedInBody).applyMatrix4(this.held.object.matrixWorld);
    this.spring.pull(this.picker.camera, this.grabbed, this.place());
  }

  private send(): void {
    this.pull();
    if (this.handlers.pushable() && this.spring.force.length() >= FAINTEST_N) this.handlers.pushed(this.spring.force);
  }
}
