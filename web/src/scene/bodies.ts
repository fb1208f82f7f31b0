// Everything that hello.scene describes: bodies, rotor discs, the payload and the ghost of the reference.
import { CircleGeometry, Color, DoubleSide, Group, Mesh, MeshBasicMaterial, MeshLambertMaterial, RingGeometry } from "three";
import type { Scene, SceneRotor } from "../protocol";
import { MARKS_LAYER } from "./layers";
import { dispose, meshOf, place } from "./shapes";

const POSE_FLOATS = 7;
const GHOST_ALPHA = 0.35;
/** From this far off its reference on the ghost is drawn in full; nearer it would only tint the vehicle, m. */
const GHOST_FULL_M = 0.15;
const DISC_ALPHA = 0.1;
const RIM_ALPHA = 0.45;

export interface DrawnPose {
  position: number[];
  quaternion_wxyz: number[];
}

export class Bodies {
  readonly root = new Group();
  readonly ghost = new Group();
  private readonly named = new Map<string, Group>();
  private readonly moving: Group[] = [];
  private readonly base: Group | undefined;
  private readonly ghostMaterial: MeshLambertMaterial;
  private readonly discMaterial: MeshBasicMaterial;
  private readonly rimMaterial: MeshBasicMaterial;

  constructor(scene: Scene, ghostColor: string, discColor: string) {
    for (const body of scene.bodies) {
      const group = new Group();
      group.name = body.name;
      place(group, body.pose);
      body.shapes.forEach((shape) => group.add(meshOf(shape)));
      this.root.add(group);
      this.named.set(body.name, group);
      if (body.moving) this.moving.push(group);
    }
    this.base = this.named.get(scene.base_body);
    this.discMaterial = glass(discColor, DISC_ALPHA);
    this.rimMaterial = glass(discColor, RIM_ALPHA);
    scene.rotors.forEach((rotor) => this.base?.add(disc(rotor, this.discMaterial), rim(rotor, this.rimMaterial)));
    this.ghostMaterial = new MeshLambertMaterial({ color: new Color(ghostColor), opacity: GHOST_ALPHA, transparent: true, depthWrite: false });
    this.buildGhost(scene, ghostColor);
    this.ghost.traverse((part) => part.layers.set(MARKS_LAYER));
    this.root.add(this.ghost);
  }

  /** Moves every body to the newest poses; false where nothing is known of the reference. */
  update(poses: Float32Array, reference: Float32Array): void {
    this.moving.forEach((group, index) => setPose(group, poses, index * POSE_FLOATS));
    this.ghost.visible = setPose(this.ghost, reference, 0);
    const off = this.base === undefined ? GHOST_FULL_M : this.ghost.position.distanceTo(this.base.position);
    this.ghostMaterial.opacity = GHOST_ALPHA * Math.min(1, off / GHOST_FULL_M);
  }

  recolor(discColor: string): void {
    this.discMaterial.color.set(discColor);
    this.rimMaterial.color.set(discColor);
  }

  /** The body called `name`. */
  body(name: string | undefined): Group | undefined {
    return name === undefined ? undefined : this.named.get(name);
  }

  /** The vehicle's root body. */
  vehicle(): Group | undefined {
    return this.base;
  }

  /** World poses as drawn, by body name. */
  drawn(): Record<string, DrawnPose> {
    const all: Record<string, DrawnPose> = {};
    for (const [name, { position: p, quaternion: q }] of this.named) {
      all[name] = { position: [p.x, p.y, p.z], quaternion_wxyz: [q.w, q.x, q.y, q.z] };
    }
    return all;
  }

  dispose(): void {
    dispose(this.root);
  }

  private buildGhost(scene: Scene, color: string): void {
    this.ghost.visible = false;
    const root = scene.bodies.find((body) => body.name === scene.base_body);
    root?.shapes.forEach((shape) => this.ghost.add(meshOf(shape, this.ghostMaterial)));
    const material = glass(color, GHOST_ALPHA);
    scene.rotors.forEach((rotor) => this.ghost.add(rim(rotor, material)));
  }
}

/** Copies a pose out of telemetry; false (and nothing changes) if it is not finite. */
function setPose(object: Group, values: Float32Array, offset: number): boolean {
  const [x, y, z, qw, qx, qy, qz] = values.subarray(offset, offset + POSE_FLOATS);
  if (x === undefined || y === undefined || z === undefined || qw === undefined || qx === undefined || qy === undefined || qz === undefined) return false;
  if (!Number.isFinite(x + y + z + qw + qx + qy + qz)) return false;
  object.position.set(x, y, z);
  object.quaternion.set(qx, qy, qz, qw);
  return true;
}

function glass(color: string, opacity: number): MeshBasicMaterial {
  return new MeshBasicMaterial({ color: new Color(color), opacity, transparent: true, depthWrite: false, side: DoubleSide });
}

function disc({ radius_m, position_in_body }: SceneRotor, material: MeshBasicMaterial): Mesh {
  const mesh = new Mesh(new CircleGeometry(radius_m, 32), material);
  mesh.position.set(...position_in_body);
  return mesh;
}

function rim({ radius_m, position_in_body }: SceneRotor, material: MeshBasicMaterial): Mesh {
  const mesh = new Mesh(new RingGeometry(radius_m * 0.96, radius_m, 40), material);
  mesh.position.set(...position_in_body);
  return mesh;
}
