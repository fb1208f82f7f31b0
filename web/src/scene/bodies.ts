// Everything that hello.scene describes: bodies, rotor discs, the payload and the ghost of the reference.
import { CircleGeometry, Color, DoubleSide, Group, Mesh, MeshBasicMaterial, MeshLambertMaterial, RingGeometry } from "three";
import type { Scene, SceneRotor } from "../protocol";
import { dispose, meshOf, place } from "./shapes";

const POSE_FLOATS = 7;
const GHOST_ALPHA = 0.35;
const DISC_ALPHA = 0.22;

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
    scene.rotors.forEach((rotor) => this.base?.add(disc(rotor, discColor)));
    this.buildGhost(scene, ghostColor);
    this.root.add(this.ghost);
  }

  /** Moves every body to the newest poses; false where nothing is known of the reference. */
  update(poses: Float32Array, reference: Float32Array): void {
    this.moving.forEach((group, index) => setPose(group, poses, index * POSE_FLOATS));
    this.ghost.visible = setPose(this.ghost, reference, 0);
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
    const material = new MeshLambertMaterial({ color: new Color(color), opacity: GHOST_ALPHA, transparent: true, depthWrite: false });
    root?.shapes.forEach((shape) => this.ghost.add(meshOf(shape, material)));
    scene.rotors.forEach((rotor) => this.ghost.add(rim(rotor, color, GHOST_ALPHA)));
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

function disc(rotor: SceneRotor, color: string): Group {
  const group = new Group();
  group.position.set(...rotor.position_in_body);
  const material = new MeshBasicMaterial({ color: new Color(color), opacity: DISC_ALPHA, transparent: true, depthWrite: false, side: DoubleSide });
  group.add(new Mesh(new CircleGeometry(rotor.radius_m, 32), material));
  const edge = rim(rotor, color, 0.7);
  edge.position.set(0, 0, 0);
  group.add(edge);
  return group;
}

function rim(rotor: SceneRotor, color: string, opacity: number): Mesh {
  const material = new MeshBasicMaterial({ color: new Color(color), opacity, transparent: true, depthWrite: false, side: DoubleSide });
  const mesh = new Mesh(new RingGeometry(rotor.radius_m * 0.94, rotor.radius_m, 40), material);
  mesh.position.set(...rotor.position_in_body);
  return mesh;
}
