// Contact points with an arrow along the force. The arrow's length grows with the root of the force, so that a 2 N grip
// and a 200 N bump both fit the picture.
import { ArrowHelper, type ColorRepresentation, Group, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from "three";

const CONTACT_FLOATS = 6;
const METRES_PER_ROOT_NEWTON = 0.04;
const LONGEST_M = 0.6;
const SHOWN_AT_MOST = 32;
const POINT_RADIUS_M = 0.008;

export class Contacts {
  readonly root = new Group();
  private readonly points: Mesh[] = [];
  private readonly arrows: ArrowHelper[] = [];
  private readonly direction = new Vector3();

  constructor(private readonly color: ColorRepresentation) {}

  update(contacts: Float32Array): void {
    const count = Math.min(SHOWN_AT_MOST, Math.floor(contacts.length / CONTACT_FLOATS));
    while (this.points.length < count) this.grow();
    this.points.forEach((point, index) => (point.visible = index < count));
    this.arrows.forEach((arrow, index) => (arrow.visible = index < count));
    for (let i = 0; i < count; i += 1) {
      const [x = NaN, y = NaN, z = NaN, fx = 0, fy = 0, fz = 0] = contacts.subarray(i * CONTACT_FLOATS, (i + 1) * CONTACT_FLOATS);
      this.show(this.points[i], this.arrows[i], [x, y, z], [fx, fy, fz]);
    }
  }

  private show(point: Mesh | undefined, arrow: ArrowHelper | undefined, at: number[], force: number[]): void {
    if (point === undefined || arrow === undefined) return;
    const [x = NaN, y = NaN, z = NaN] = at;
    const [fx = 0, fy = 0, fz = 0] = force;
    const newtons = Math.hypot(fx, fy, fz);
    point.visible = Number.isFinite(x + y + z);
    arrow.visible = point.visible && Number.isFinite(newtons) && newtons > 0;
    point.position.set(x, y, z);
    if (!arrow.visible) return;
    arrow.position.set(x, y, z);
    arrow.setDirection(this.direction.set(fx, fy, fz).normalize());
    const length = Math.min(LONGEST_M, METRES_PER_ROOT_NEWTON * Math.sqrt(newtons));
    arrow.setLength(length, Math.min(0.05, length * 0.4), Math.min(0.03, length * 0.25));
  }

  private grow(): void {
    const point = new Mesh(new SphereGeometry(POINT_RADIUS_M, 10, 6), new MeshBasicMaterial({ color: this.color }));
    const arrow = new ArrowHelper(new Vector3(0, 0, 1), new Vector3(), 0.1, this.color);
    this.points.push(point);
    this.arrows.push(arrow);
    this.root.add(point, arrow);
  }
}
