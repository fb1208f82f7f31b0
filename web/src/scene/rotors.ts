// Rotor discs with faint blades that turn and become more visible with the thrust. They turn much slower than the real rotor: at its
// 100 turns per second, 60 pictures per second would show blades that stand still or run backwards. All rotors are one mesh whose
// blade corners are computed anew, because without a graphics card every further mesh costs more than all of these corners.
import { type BufferAttribute, type BufferGeometry, CircleGeometry, Color, DoubleSide, Float32BufferAttribute, Mesh, MeshBasicMaterial, RingGeometry } from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import type { SceneRotor } from "../protocol";

export const DISC_ALPHA = 0.08;
export const RIM_ALPHA = 0.45;
const BLADE_RAD = 0.7;
const BLADE_ALPHA_PER_NEWTON = 0.022;
const MOST_BLADE_ALPHA = 0.34;
/** Turns per second at 1 N. The speed grows with the root of the thrust, as that of a real rotor. */
const TURNS_PER_S = 0.6;
/** Longest time step of the turn, s, so that a page that was hidden for a while does not turn the rotors far at once. */
const LONGEST_STEP_S = 0.1;

export function glass(color: string, opacity: number): MeshBasicMaterial {
  return new MeshBasicMaterial({ color: new Color(color), opacity, transparent: true, depthWrite: false, side: DoubleSide, forceSinglePass: true });
}

/** The rims of all rotors; empty for a vehicle without rotors. */
export function rims(rotors: SceneRotor[], material: MeshBasicMaterial): Mesh[] {
  return rotors.length === 0 ? [] : [new Mesh(mergeGeometries(rotors.map(rim)), material)];
}

function rim({ radius_m, position_in_body }: SceneRotor): BufferGeometry {
  return bare(new RingGeometry(radius_m * 0.96, radius_m, 40)).translate(...position_in_body);
}

function disc({ radius_m, position_in_body }: SceneRotor): BufferGeometry {
  return bare(new CircleGeometry(radius_m, 32)).translate(...position_in_body);
}

/** The blades of one rotor: two sectors around the origin. */
function blades({ radius_m }: SceneRotor): BufferGeometry {
  const sector = (start: number): BufferGeometry => bare(new CircleGeometry(radius_m * 0.95, 6, start, BLADE_RAD));
  return mergeGeometries([sector(0), sector(Math.PI)]);
}

/** The geometry with positions only. */
function bare(geometry: BufferGeometry): BufferGeometry {
  return geometry.deleteAttribute("normal").deleteAttribute("uv");
}

/** Blades of one rotor: their corners at rest, x y z in m, and the index of their first corner in the mesh. */
interface Blades {
  rest: ArrayLike<number>;
  first: number;
  angle: number;
}

export class Rotors {
  /** The mesh of all rotors; empty for a vehicle without rotors. */
  readonly meshes: Mesh<BufferGeometry, MeshBasicMaterial>[] = [];
  private readonly blades: Blades[] = [];

  constructor(
    private readonly rotors: SceneRotor[],
    color: string,
  ) {
    if (rotors.length === 0) return;
    const parts: BufferGeometry[] = [];
    const alphas: number[] = [];
    const add = (part: BufferGeometry, alpha: number): void => {
      parts.push(part);
      for (let i = 0; i < part.getAttribute("position").count; i += 1) alphas.push(alpha);
    };
    for (const rotor of rotors) {
      add(disc(rotor), DISC_ALPHA);
      add(rim(rotor), RIM_ALPHA);
    }
    for (const rotor of rotors) {
      const turning = blades(rotor);
      this.blades.push({ rest: turning.getAttribute("position").array, first: alphas.length, angle: 0 });
      add(turning, 0);
    }
    const geometry = mergeGeometries(parts);
    geometry.setAttribute("color", new Float32BufferAttribute(alphas.flatMap((alpha) => [1, 1, 1, alpha]), 4));
    const material = glass(color, 1);
    material.vertexColors = true;
    const mesh = new Mesh(geometry, material);
    // The first turn moves the blades to their discs; before it their bounds would be wrong.
    mesh.frustumCulled = false;
    this.meshes.push(mesh);
  }

  recolor(color: string): void {
    this.meshes.forEach(({ material }) => material.color.set(color));
  }

  /** Turns the blades for `dt` seconds at the thrusts (N) in `values` from `offset` on. A rotor with unknown thrust shows no blades. */
  turn(dt: number, values: Float32Array, offset: number): void {
    const geometry = this.meshes[0]?.geometry;
    if (geometry === undefined) return;
    const [corners, colors] = [geometry.getAttribute("position") as BufferAttribute, geometry.getAttribute("color") as BufferAttribute];
    const step = Math.min(dt, LONGEST_STEP_S) * TURNS_PER_S * 2 * Math.PI;
    this.blades.forEach((blade, i) => {
      const newtons = values[offset + i] ?? NaN;
      const rotor = this.rotors[i];
      if (rotor === undefined) return;
      if (newtons > 0) blade.angle += step * Math.sqrt(newtons) * rotor.spin;
      const alpha = newtons > 0 ? Math.min(MOST_BLADE_ALPHA, newtons * BLADE_ALPHA_PER_NEWTON) : 0;
      const [c, s] = [Math.cos(blade.angle), Math.sin(blade.angle)];
      const [x0, y0, z0] = rotor.position_in_body;
      for (let k = 0; k < blade.rest.length / 3; k += 1) {
        const [x, y] = [blade.rest[3 * k] ?? 0, blade.rest[3 * k + 1] ?? 0];
        corners.setXYZ(blade.first + k, x0 + c * x - s * y, y0 + s * x + c * y, z0);
        colors.setW(blade.first + k, alpha);
      }
    });
    corners.needsUpdate = true;
    colors.needsUpdate = true;
  }
}
