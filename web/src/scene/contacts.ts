// Contact points with an arrow along the force. The arrow's length grows with the root of the force, so that a 2 N grip
// and a 200 N bump both fit the picture. They show through bodies: contacts are always between two.
import { type ColorRepresentation, Group, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from "three";
import { Arrow } from "./arrow";

const CONTACT_FLOATS = 6;
const METRES_PER_ROOT_NEWTON = 0.03;
const LONGEST_M = 0.6;
const SHOWN_AT_MOST = 32;
const POINT_RADIUS_M = 0.006;

export class Contacts {
  readonly root = new Group();
  readonly material: MeshBasicMaterial;
  private readonly points: Mesh[] = [];
  private readonly arrows: Arrow[] = [];
  private readonly direction = new Vector3();

  constructor(color: ColorRepresentation) {
    this.material = new MeshBasicMaterial({ color, depthTest: false, transparent: true });
  }

  update(contacts: Float32Array): void {
    const count = Math.min(SHOWN_AT_MOST, Math.floor(contacts.length / CONTACT_FLOATS));
    while (this.points.length < count) this.grow();
    this.points.forEach((point, index) => (point.visible = index < count));
    this.arrows.forEach((arrow, index) => (arrow.root.visible = index < count));
    for (let i = 0; i < count; i += 1) {
      const [x = NaN, y = NaN, z = NaN, fx = 0, fy = 0, fz = 0] = contacts.subarray(i * CONTACT_FLOATS, (i + 1) * CONTACT_FLOATS);
      this.show(this.points[i], this.arrows[i], [x, y, z], [fx, fy, fz]);
    }
  }

  private show(point: Mesh | undefined, arrow: Arrow | undefined, at: number[], force: number[]): void {
    if (point === undefined || arrow === undefined) return;
    const [x = NaN, y = NaN, z = NaN] = at;
    const [fx = 0, fy = 0, fz = 0] = force;
    const newtons = Math.hypot(fx, fy, fz);
    point.visible = Number.isFinite(x + y + z);
    arrow.root.visible = point.visible && Number.isFinite(newtons) && newtons > 0;
    point.position.set(x, y, z);
    if (!arrow.root.visible) return;
    const length = Math.min(LONGEST_M, METRES_PER_ROOT_NEWTON * Math.sqrt(newtons));
    arrow.point(point.position, this.direction.set(fx, fy, fz).normalize(), length);
  }

  private grow(): void {
    const point = new Mesh(new SphereGeometry(POINT_RADIUS_M, 10, 6), this.material);
    const arrow = new Arrow(this.material);
    point.renderOrder = 1;
    arrow.root.traverse((part) => (part.renderOrder = 1));
    this.points.push(point);
    this.arrows.push(arrow);
    this.root.add(point, arrow.root);
  }
}
