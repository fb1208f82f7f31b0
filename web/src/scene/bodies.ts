// Everything that hello.scene describes: bodies, rotor discs, the payload and the ghost of the reference. The ghost is the
// vehicle's root alone: telemetry gives the reference of the root, not of the arm.
import { Box3, Color, Group, type Mesh, MeshLambertMaterial, Vector3 } from "three";
import { POSE_FLOATS } from "../data/pose";
import type { Scene, SceneGroup } from "../protocol";
import { MARKS_LAYER } from "./layers";
import { glass, rims, Rotors } from "./rotors";
import { dispose, meshesOf, place } from "./shapes";

const GHOST_ALPHA = 0.35;
/** From this distance between vehicle and reference on, the ghost has its full opacity; nearer it would only tint the vehicle, m. */
const GHOST_FULL_M = 0.15;
/** At a smaller distance the ghost is not drawn, because it would look the same as the vehicle, m. */
const GHOST_FROM_M = 0.01;
/** Half size of the box of a body without shapes, m. */
const SHAPELESS_HALF_M = 0.015;

export interface DrawnPose {
  position: number[];
  quaternion_wxyz: number[];
}

export interface Body {
  name: string;
  group: SceneGroup;
  object: Group;
  /** Box around the shapes of the body, in its own frame, m. */
  box: Box3;
  /** Index among the poses of a frame; -1 if the body does not move. */
  index: number;
}

export class Bodies {
  readonly root = new Group();
  readonly ghost = new Group();
  readonly rotors: Rotors;
  readonly moving: Body[];
  private readonly all = new Map<string, Body>();
  private readonly base: Body | undefined;
  private readonly ghostMaterial: MeshLambertMaterial;
  private ghostKnown = false;

  constructor(scene: Scene, ghostColor: string, discColor: string) {
    let index = 0;
    for (const { name, group, moving, pose, shapes } of scene.bodies) {
      const object = new Group();
      object.name = name;
      place(object, pose);
      meshesOf(shapes).forEach((mesh) => object.add(mesh));
      this.root.add(object);
      this.all.set(name, { name, group, object, box: boxOf(object), index: moving ? index++ : -1 });
    }
    this.moving = this.list().filter((body) => body.index >= 0);
    this.base = this.all.get(scene.base_body);
    this.ghostMaterial = new MeshLambertMaterial({ color: new Color(ghostColor), opacity: GHOST_ALPHA, transparent: true, depthWrite: false });
    this.buildGhost(scene, ghostColor);
    this.rotors = new Rotors(scene.rotors, discColor);
    this.rotors.meshes.forEach((mesh) => this.base?.object.add(mesh));
    this.root.add(this.ghost);
  }

  /** Moves every body to its pose in `poses` (moving bodies in order, then the reference). */
  update(poses: Float32Array, showGhost: boolean): void {
    for (const { object, index } of this.moving) setPose(object, poses, index * POSE_FLOATS);
    this.ghostKnown = setPose(this.ghost, poses, this.moving.length * POSE_FLOATS);
    const off = this.base === undefined ? GHOST_FULL_M : this.ghost.position.distanceTo(this.base.object.position);
    this.ghostMaterial.opacity = GHOST_ALPHA * Math.min(1, off / GHOST_FULL_M);
    this.ghost.visible = this.ghostKnown && showGhost && off > GHOST_FROM_M;
  }

  recolor(discColor: string): void {
    this.rotors.recolor(discColor);
  }

  list(): Body[] {
    return [...this.all.values()];
  }

  body(name: string | undefined): Body | undefined {
    return name === undefined ? undefined : this.all.get(name);
  }

  /** The vehicle's root body. */
  vehicle(): Body | undefined {
    return this.base;
  }

  /** Distance of the vehicle's root from its reference, m; NaN if there is none. */
  offReference(): number {
    return this.ghostKnown && this.base !== undefined ? this.ghost.position.distanceTo(this.base.object.position) : NaN;
  }

  /** World poses as drawn, by body name. */
  drawn(): Record<string, DrawnPose> {
    const poses: Record<string, DrawnPose> = {};
    for (const { name, object } of this.all.values()) {
      const { position: p, quaternion: q } = object;
      poses[name] = { position: [p.x, p.y, p.z], quaternion_wxyz: [q.w, q.x, q.y, q.z] };
    }
    return poses;
  }

  dispose(): void {
    dispose(this.root);
  }

  private buildGhost(scene: Scene, color: string): void {
    this.ghost.visible = false;
    for (const part of this.base?.object.children ?? []) {
      const copy = (part as Mesh).clone();
      copy.material = this.ghostMaterial;
      this.ghost.add(copy);
    }
    rims(scene.rotors, glass(color, GHOST_ALPHA)).forEach((mesh) => this.ghost.add(mesh));
    this.ghost.traverse((part) => part.layers.set(MARKS_LAYER));
  }
}

/** Box around the children of `object` in its own frame. */
function boxOf(object: Group): Box3 {
  const box = new Box3();
  const own = new Box3();
  for (const child of object.children as Mesh[]) {
    child.geometry.computeBoundingBox();
    child.updateMatrix();
    if (child.geometry.boundingBox !== null) box.union(own.copy(child.geometry.boundingBox).applyMatrix4(child.matrix));
  }
  if (box.isEmpty()) box.setFromCenterAndSize(new Vector3(), new Vector3().setScalar(2 * SHAPELESS_HALF_M));
  return box;
}

/** Copies a pose; returns false and changes nothing if the pose is not finite. */
function setPose(object: Group, values: Float32Array, k: number): boolean {
  let sum = 0;
  for (let i = k; i < k + POSE_FLOATS; i += 1) sum += values[i] ?? NaN;
  if (!Number.isFinite(sum)) return false;
  object.position.set(values[k] ?? 0, values[k + 1] ?? 0, values[k + 2] ?? 0);
  object.quaternion.set(values[k + 4] ?? 0, values[k + 5] ?? 0, values[k + 6] ?? 0, values[k + 3] ?? 1);
  return true;
}
