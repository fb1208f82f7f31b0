// Arrows at the vehicle: the thrust of each rotor and their sum, the residual estimate, the adapter's share of it, and the wind.
// All forces have the same scale, so that their arrows may be compared by eye. An unknown force or wind is not drawn.
import { type ColorRepresentation, MeshBasicMaterial, type Object3D, Vector3 } from "three";
import type { Palette } from "../panels/theme";
import type { SceneRotor } from "../protocol";
import { type Arrow, Arrows, type DrawnArrow } from "./arrow";
import type { SceneChannels } from "./channels";
import { MARKS_LAYER } from "./layers";
import type { ViewSettings } from "./settings";

export const METRES_PER_NEWTON = 0.0125;
export const METRES_PER_METRE_PER_SECOND = 0.08;
const LONGEST_WIND_M = 0.8;
/** A weaker wind counts as calm, m/s. */
const CALM_M_S = 0.05;
/** The wind's arrows end this far upwind of the vehicle, side by side and one above the other, m. */
const WIND_STANDOFF_M = 0.42;
const WIND_PLACES = [new Vector3(0, 0, 0), new Vector3(0, 0.13, 0.1), new Vector3(0, -0.13, 0.1)];
/** Feet of the long arrows in the body frame, m. They stand beside each other, so that upright arrows do not hide each other. */
const TOTAL_FOOT = new Vector3(0, 0, 0.03);
const ESTIMATE_FOOT = new Vector3(-0.06, 0.06, 0.03);
const ADAPTER_FOOT = new Vector3(0.06, -0.06, 0.03);
const UP = new Vector3(0, 0, 1);
const UNKNOWN = new Vector3(NaN, NaN, NaN);

export class Forces {
  private readonly material = new MeshBasicMaterial();
  private readonly arrows: Arrows;
  private readonly hubs: Vector3[];
  private readonly rotors: Arrow[];
  private readonly total: Arrow;
  private readonly estimate: Arrow;
  private readonly adapter: Arrow;
  private readonly winds: Arrow[];
  private readonly foot = new Vector3();
  private readonly way = new Vector3();
  private readonly side = new Vector3();

  constructor(
    rotors: SceneRotor[],
    private readonly channels: SceneChannels,
    palette: Palette,
  ) {
    this.hubs = rotors.map(({ position_in_body }) => new Vector3(...position_in_body));
    this.arrows = new Arrows(this.material, rotors.length + 3 + WIND_PLACES.length);
    this.rotors = rotors.map(() => this.arrows.add(1.4, palette.ink));
    this.total = this.arrows.add(2, palette.ink);
    this.estimate = this.arrows.add(2, palette.estimate);
    this.adapter = this.arrows.add(2, palette.warn);
    this.winds = WIND_PLACES.map(() => this.arrows.add(1.4, palette.third));
    this.root.traverse((part) => part.layers.set(MARKS_LAYER));
  }

  get root(): Object3D {
    return this.arrows.root;
  }

  recolor(palette: Palette): void {
    const paint = (arrows: Arrow[], color: ColorRepresentation): void => arrows.forEach((arrow) => arrow.color.set(color));
    paint([...this.rotors, this.total], palette.ink);
    paint([this.estimate], palette.estimate);
    paint([this.adapter], palette.warn);
    paint(this.winds, palette.third);
  }

  /** Writes the visible arrows into the meshes; call it before drawing. */
  pack(): void {
    this.arrows.pack();
  }

  /** Shows `values` as arrows at the vehicle `base`; from `offset` on they have the layout of `SceneChannels`. */
  update(base: Object3D, values: Float32Array, offset: number, shown: ViewSettings["shown"]): void {
    let sum = 0;
    this.rotors.forEach((arrow, i) => {
      const newtons = values[offset + i] ?? NaN;
      sum += newtons;
      this.foot.copy(this.hubs[i] ?? UNKNOWN).applyQuaternion(base.quaternion).add(base.position);
      this.way.copy(UP).applyQuaternion(base.quaternion).multiplyScalar(newtons * METRES_PER_NEWTON);
      draw(arrow, shown.thrust, this.foot, this.way);
    });
    this.way.copy(UP).applyQuaternion(base.quaternion).multiplyScalar(sum * METRES_PER_NEWTON);
    draw(this.total, shown.total_thrust && this.rotors.length > 0, this.stand(base, TOTAL_FOOT), this.way);
    this.read(values, offset + this.channels.estimateAt, METRES_PER_NEWTON);
    draw(this.estimate, shown.estimate, this.stand(base, ESTIMATE_FOOT), this.way);
    this.read(values, offset + this.channels.adapterAt, METRES_PER_NEWTON);
    draw(this.adapter, shown.adapter, this.stand(base, ADAPTER_FOOT), this.way);
    this.blow(base, values, offset + this.channels.windAt, shown.wind);
  }

  hide(): void {
    for (const arrow of this.all()) arrow.hide();
  }

  dispose(): void {
    this.arrows.dispose();
    this.material.dispose();
  }

  drawn(): Record<string, DrawnArrow> {
    const named: [string, Arrow | undefined][] = [
      ...this.rotors.map((arrow, i): [string, Arrow] => [`rotor.${i}`, arrow]),
      ["thrust_total", this.total],
      ["estimate", this.estimate],
      ["adapter", this.adapter],
      ["wind", this.winds[0]],
    ];
    return Object.fromEntries(named.map(([name, arrow]) => [name, arrow?.drawn() ?? null]).filter(([, arrow]) => arrow !== null));
  }

  /** Shows the wind. Its arrows stand upwind of the vehicle, point towards it and end before it. */
  private blow(base: Object3D, values: Float32Array, at: number, shown: boolean): void {
    this.read(values, at, 1);
    const speed = this.way.length();
    const blows = shown && speed >= CALM_M_S;
    if (blows) this.side.copy(this.way).cross(UP).setLength(1);
    const length = Math.min(LONGEST_WIND_M, speed * METRES_PER_METRE_PER_SECOND);
    this.winds.forEach((arrow, i) => {
      if (!blows) return arrow.hide();
      const place = WIND_PLACES[i] ?? UP;
      this.way.setLength(WIND_STANDOFF_M + length);
      this.foot.copy(base.position).sub(this.way).addScaledVector(UP, place.z);
      if (Number.isFinite(this.side.x)) this.foot.addScaledVector(this.side, place.y);
      arrow.show(this.foot, this.way.setLength(length));
    });
  }

  private stand(base: Object3D, inBody: Vector3): Vector3 {
    return this.foot.copy(inBody).applyQuaternion(base.quaternion).add(base.position);
  }

  private read(values: Float32Array, at: number, scale: number): void {
    this.way.set(values[at] ?? NaN, values[at + 1] ?? NaN, values[at + 2] ?? NaN).multiplyScalar(scale);
  }

  private all(): Arrow[] {
    return [...this.rotors, this.total, this.estimate, this.adapter, ...this.winds];
  }
}

function draw(arrow: Arrow, shown: boolean, foot: Vector3, way: Vector3): void {
  if (shown) arrow.show(foot, way);
  else arrow.hide();
}
