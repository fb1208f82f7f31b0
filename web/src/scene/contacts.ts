// Contact points with an arrow along the force. The arrow's length grows with the root of the force, so that a 2 N grip
// and a 200 N bump both fit the picture. They show through bodies: contacts are always between two.
import { type ColorRepresentation, Group, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from "three";
import { Arrow, type DrawnArrow } from "./arrow";

const CONTACT_FLOATS = 6;
export const METRES_PER_ROOT_NEWTON = 0.03;
const LONGEST_M = 0.6;
const SHOWN_AT_MOST = 32;
const POINT = new SphereGeometry(0.006, 10, 6);

export class Contacts {
  readonly root = new Group();
  readonly material: MeshBasicMaterial;
  private readonly points: Mesh[] = [];
  private readonly arrows: Arrow[] = [];
  private readonly way = new Vector3();

  constructor(color: ColorRepresentation) {
    this.material = new MeshBasicMaterial({ color, depthTest: false, transparent: true });
  }

  /** Point (m) and force (N) of each contact, world frame. */
  update(contacts: Float32Array): void {
    const count = Math.min(SHOWN_AT_MOST, Math.floor(contacts.length / CONTACT_FLOATS));
    while (this.points.length < count) this.grow();
    this.points.forEach((point, index) => (point.visible = index < count));
    this.arrows.forEach((arrow) => arrow.hide());
    for (let i = 0; i < count; i += 1) this.show(this.points[i], this.arrows[i], contacts, i * CONTACT_FLOATS);
  }

  drawn(): DrawnArrow[] {
    return this.root.visible ? this.arrows.map((arrow) => arrow.drawn()).filter((arrow) => arrow !== null) : [];
  }

  private show(point: Mesh | undefined, arrow: Arrow | undefined, contacts: Float32Array, k: number): void {
    if (point === undefined || arrow === undefined) return;
    point.position.set(contacts[k] ?? NaN, contacts[k + 1] ?? NaN, contacts[k + 2] ?? NaN);
    point.visible = Number.isFinite(point.position.lengthSq());
    const newtons = this.way.set(contacts[k + 3] ?? NaN, contacts[k + 4] ?? NaN, contacts[k + 5] ?? NaN).length();
    if (!(newtons > 0)) return;
    this.way.setLength(Math.min(LONGEST_M, METRES_PER_ROOT_NEWTON * Math.sqrt(newtons)));
    arrow.show(point.position, this.way);
  }

  private grow(): void {
    const point = new Mesh(POINT, this.material);
    const arrow = new Arrow(this.material);
    point.renderOrder = 1;
    arrow.root.traverse((part) => (part.renderOrder = 1));
    this.points.push(point);
    this.arrows.push(arrow);
    this.root.add(point, arrow.root);
  }
}
