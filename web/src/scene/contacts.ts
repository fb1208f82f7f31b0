// Contact points with an arrow along the force. The arrow's length grows with the root of the force, so that a grip of 2 N and a
// bump of 200 N both fit the picture. The arrows show through bodies, because a contact always lies between two bodies.
import { type ColorRepresentation, Group, InstancedMesh, Matrix4, MeshBasicMaterial, SphereGeometry, Vector3 } from "three";
import { type Arrow, Arrows, type DrawnArrow } from "./arrow";

const CONTACT_FLOATS = 6;
export const METRES_PER_ROOT_NEWTON = 0.03;
const LONGEST_M = 0.6;
const SHOWN_AT_MOST = 32;
const POINT = new SphereGeometry(0.006, 10, 6);

export class Contacts {
  readonly root = new Group();
  private readonly material = new MeshBasicMaterial({ depthTest: false, transparent: true });
  private readonly dots = new InstancedMesh(POINT, this.material, SHOWN_AT_MOST);
  private readonly field = new Arrows(this.material, SHOWN_AT_MOST);
  private readonly arrows: Arrow[];
  private readonly place = new Vector3();
  private readonly way = new Vector3();
  private readonly matrix = new Matrix4();

  constructor(color: ColorRepresentation) {
    this.arrows = Array.from({ length: SHOWN_AT_MOST }, () => this.field.add(1, 0xffffff));
    this.recolor(color);
    this.dots.frustumCulled = false;
    this.dots.count = 0;
    this.root.add(this.dots, this.field.root);
    this.root.traverse((part) => (part.renderOrder = 1));
  }

  recolor(color: ColorRepresentation): void {
    this.material.color.set(color);
  }

  /** Takes the point (m) and the force (N) of each contact, in the world. */
  update(contacts: Float32Array): void {
    this.arrows.forEach((arrow) => arrow.hide());
    this.dots.count = 0;
    const count = Math.min(SHOWN_AT_MOST, Math.floor(contacts.length / CONTACT_FLOATS));
    for (let i = 0; i < count; i += 1) this.show(this.arrows[i], contacts, i * CONTACT_FLOATS);
    this.dots.visible = this.dots.count > 0;
    this.dots.instanceMatrix.needsUpdate = true;
  }

  /** Writes the visible arrows into the meshes; call it before drawing. */
  pack(): void {
    this.field.pack();
  }

  drawn(): DrawnArrow[] {
    return this.root.visible ? this.arrows.map((arrow) => arrow.drawn()).filter((arrow) => arrow !== null) : [];
  }

  private show(arrow: Arrow | undefined, contacts: Float32Array, k: number): void {
    if (arrow === undefined) return;
    this.place.set(contacts[k] ?? NaN, contacts[k + 1] ?? NaN, contacts[k + 2] ?? NaN);
    if (!Number.isFinite(this.place.lengthSq())) return;
    this.dots.setMatrixAt(this.dots.count, this.matrix.makeTranslation(this.place));
    this.dots.count += 1;
    const newtons = this.way.set(contacts[k + 3] ?? NaN, contacts[k + 4] ?? NaN, contacts[k + 5] ?? NaN).length();
    if (!(newtons > 0)) return;
    this.way.setLength(Math.min(LONGEST_M, METRES_PER_ROOT_NEWTON * Math.sqrt(newtons)));
    arrow.show(this.place, this.way);
  }
}
