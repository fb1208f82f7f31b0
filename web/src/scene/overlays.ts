// Overlays over the bodies that explain the flight: trails, forces, contacts, frames, brackets, and the spring of a push. All are
// parts of one scene and follow the settings of the view.
import { MeshBasicMaterial, type Scene as ThreeScene, Vector3 } from "three";
import type { Palette } from "../panels/theme";
import type { Hello } from "../protocol";
import { type Arrow, Arrows, type DrawnArrow } from "./arrow";
import type { Bodies } from "./bodies";
import { Brackets } from "./brackets";
import type { SceneChannels } from "./channels";
import { Contacts } from "./contacts";
import { Forces } from "./forces";
import { type FrameHolder, Frames } from "./frames";
import { handOf } from "./hand";
import { MARKS_LAYER } from "./layers";
import type { PushSpring } from "./push";
import type { ViewSettings } from "./settings";
import { Shadow } from "./shadow";
import { Trail } from "./trail";

const HOVER_ALPHA = 0.55;

export class Overlays {
  readonly hovered: Brackets;
  readonly chosen: Brackets;
  readonly contacts: Contacts;
  private readonly flown: Trail;
  private readonly wanted: Trail;
  private readonly shadow = new Shadow();
  private readonly pushMaterial: MeshBasicMaterial;
  private readonly pushes: Arrows;
  private readonly push: Arrow;
  private readonly pushWay = new Vector3();
  private height = 600;
  private forces: Forces | null = null;
  private frames: Frames | null = null;

  constructor(
    private readonly scene: ThreeScene,
    private palette: Palette,
    private readonly settings: ViewSettings,
  ) {
    this.hovered = new Brackets(palette.focus, HOVER_ALPHA);
    this.chosen = new Brackets(palette.focus, 1);
    this.contacts = new Contacts(palette.fourth);
    this.flown = new Trail(palette.estimate, false);
    this.wanted = new Trail(palette.setpoint, true);
    this.pushMaterial = new MeshBasicMaterial({ color: palette.focus, depthTest: false, transparent: true });
    this.pushes = new Arrows(this.pushMaterial, 1);
    this.push = this.pushes.add(1.6, 0xffffff);
    this.pushes.root.traverse((part) => {
      part.layers.set(MARKS_LAYER);
      part.renderOrder = 3;
    });
    scene.add(this.wanted.line, this.flown.line, this.contacts.root, this.shadow.mesh, this.pushes.root);
  }

  /** Builds the overlays for another flight. */
  rebuild(hello: Hello, bodies: Bodies, channels: SceneChannels): void {
    this.hovered.surround(undefined);
    this.chosen.surround(undefined);
    this.forces?.dispose();
    this.frames?.dispose();
    this.forces = new Forces(hello.scene.rotors, channels, this.palette);
    this.frames = new Frames(holders(hello, bodies, this.scene), this.palette, this.settings.shown);
    this.frames.resize(this.height);
    this.scene.add(this.forces.root);
    this.apply();
  }

  /** Applies changed settings. */
  apply(): void {
    const { shown, trailS } = this.settings;
    this.frames?.apply(shown);
    this.flown.line.visible = shown.trail;
    this.wanted.line.visible = shown.reference_trail;
    this.flown.setSpan(trailS);
    this.wanted.setSpan(trailS);
  }

  clear(): void {
    this.flown.clear();
    this.wanted.clear();
    this.contacts.update(new Float32Array());
    this.forces?.hide();
  }

  resize(width: number, height: number): void {
    this.flown.resize(width, height);
    this.wanted.resize(width, height);
    this.height = height;
    this.frames?.resize(height);
  }

  /** Adds the positions of the vehicle and its reference, which stand at these indices of `poses`, to the trails at `time`, s. */
  remember(poses: Float32Array, vehicle: number, reference: number, time: number): void {
    this.flown.add(poses[vehicle] ?? NaN, poses[vehicle + 1] ?? NaN, poses[vehicle + 2] ?? NaN, time);
    this.wanted.add(poses[reference] ?? NaN, poses[reference + 1] ?? NaN, poses[reference + 2] ?? NaN, time);
  }

  /** Moves all overlays to the shown `bodies`. Forces come from `values` at `offset`; they are hidden if the data are `old`. */
  place(bodies: Bodies, values: Float32Array, offset: number, time: number, old: boolean): void {
    const base = bodies.vehicle()?.object;
    if (base === undefined) return;
    this.flown.end(base.position.x, base.position.y, base.position.z, time);
    this.wanted.end(bodies.ghost.position.x, bodies.ghost.position.y, bodies.ghost.position.z, time);
    this.shadow.follow(base.position);
    this.contacts.root.visible = this.settings.shown.contact && !old;
    if (old) this.forces?.hide();
    else this.forces?.update(base, values, offset, this.settings.shown);
  }

  /** Prepares the overlays for drawing from `eye`, in the world, m. */
  seenFrom(eye: Vector3): void {
    this.frames?.seenFrom(eye);
    this.forces?.pack();
    this.contacts.pack();
    this.pushes.pack();
  }

  /** Shows the spring of a push; null hides it. */
  pull(spring: PushSpring | null, newtonsPerMetre: number): void {
    if (spring === null) return this.push.hide();
    this.push.show(spring.grabbed, this.pushWay.copy(spring.force).divideScalar(newtonsPerMetre));
  }

  recolor(palette: Palette): void {
    this.palette = palette;
    this.flown.recolor(palette.estimate);
    this.wanted.recolor(palette.setpoint);
    this.contacts.recolor(palette.fourth);
    this.pushMaterial.color.set(palette.focus);
    this.hovered.recolor(palette.focus);
    this.chosen.recolor(palette.focus);
    this.forces?.recolor(palette);
    this.frames?.recolor(palette);
  }

  /** The overlays as drawn: arrows by name, contacts, kinds of frames, and the number of points of the trail. */
  drawn(): { arrows: Record<string, DrawnArrow>; contacts: DrawnArrow[]; frames: string[]; trail: number } {
    return { arrows: this.forces?.drawn() ?? {}, contacts: this.contacts.drawn(), frames: this.frames?.drawn() ?? [], trail: this.flown.line.visible ? this.flown.length : 0 };
  }
}

/** The bodies that have frames, with the kind of each frame. */
function holders({ scene }: Hello, bodies: Bodies, world: ThreeScene): FrameHolder[] {
  const tool = handOf(scene);
  const moving = bodies.moving.map(({ name, group, object }): FrameHolder => {
    const kind = group === "payload" ? "payload" : name === scene.base_body ? "body" : name === tool ? "tool" : "links";
    return { kind, name, object };
  });
  return [{ kind: "world", name: "world", object: world }, ...moving];
}
