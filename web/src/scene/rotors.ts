// Rotor discs with a hint of blades: they turn, and show more the harder the rotor pulls. The speed is a hint, not the
// rotor's own: at a true 100 turns a second a picture sixty times a second would stand still or run backwards.
import { CircleGeometry, Color, DoubleSide, Group, Mesh, MeshBasicMaterial, RingGeometry } from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import type { SceneRotor } from "../protocol";

export const DISC_ALPHA = 0.08;
export const RIM_ALPHA = 0.45;
const BLADE_RAD = 0.7;
const BLADE_ALPHA_PER_NEWTON = 0.022;
const MOST_BLADE_ALPHA = 0.34;
/** At 1 N; grows with the root of the thrust, as the true speed does. */
const TURNS_PER_S = 0.6;
/** A page that was hidden for a while does not wind the rotors up, s. */
const LONGEST_STEP_S = 0.1;

export function glass(color: string, opacity: number): MeshBasicMaterial {
  return new MeshBasicMaterial({ color: new Color(color), opacity, transparent: true, depthWrite: false, side: DoubleSide });
}

export function rim({ radius_m, position_in_body }: SceneRotor, material: MeshBasicMaterial): Mesh {
  const mesh = new Mesh(new RingGeometry(radius_m * 0.96, radius_m, 40), material);
  mesh.position.set(...position_in_body);
  return mesh;
}

function blades({ radius_m, position_in_body }: SceneRotor, material: MeshBasicMaterial): Mesh {
  const sector = (start: number): CircleGeometry => new CircleGeometry(radius_m * 0.95, 6, start, BLADE_RAD);
  const mesh = new Mesh(mergeGeometries([sector(0), sector(Math.PI)]), material);
  mesh.position.set(...position_in_body);
  return mesh;
}

function disc({ radius_m, position_in_body }: SceneRotor, material: MeshBasicMaterial): Mesh {
  const mesh = new Mesh(new CircleGeometry(radius_m, 32), material);
  mesh.position.set(...position_in_body);
  return mesh;
}

export class Rotors {
  readonly root = new Group();
  private readonly turning: Mesh<CircleGeometry, MeshBasicMaterial>[];
  private readonly materials: MeshBasicMaterial[];

  constructor(
    private readonly rotors: SceneRotor[],
    color: string,
  ) {
    const [discs, rims] = [glass(color, DISC_ALPHA), glass(color, RIM_ALPHA)];
    this.turning = rotors.map((rotor) => blades(rotor, glass(color, 0)) as Mesh<CircleGeometry, MeshBasicMaterial>);
    rotors.forEach((rotor) => this.root.add(disc(rotor, discs), rim(rotor, rims)));
    this.turning.forEach((blade) => this.root.add(blade));
    this.materials = [discs, rims, ...this.turning.map(({ material }) => material)];
  }

  recolor(color: string): void {
    this.materials.forEach((material) => material.color.set(color));
  }

  /** Turns the blades by `dt` seconds at the thrusts (N) from `offset` of `values` on; unknown thrust shows no blades. */
  turn(dt: number, values: Float32Array, offset: number): void {
    const step = Math.min(dt, LONGEST_STEP_S) * TURNS_PER_S * 2 * Math.PI;
    this.turning.forEach((blade, i) => {
      const newtons = values[offset + i] ?? NaN;
      blade.visible = newtons > 0;
      if (!blade.visible) return;
      blade.material.opacity = Math.min(MOST_BLADE_ALPHA, newtons * BLADE_ALPHA_PER_NEWTON);
      blade.rotation.z += step * Math.sqrt(newtons) * (this.rotors[i]?.spin ?? 1);
    });
  }
}
