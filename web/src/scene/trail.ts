// The path of a body as one line with a bounded number of points, which fades with age. Each piece of the path is a quad that the
// shader widens on the screen, so that the line is visible from afar; the page computes nothing per point and frame.
import { BufferGeometry, Color, Float32BufferAttribute, InstancedBufferGeometry, InstancedInterleavedBuffer, InterleavedBufferAttribute, Mesh, ShaderMaterial, Vector2, type ColorRepresentation } from "three";
import { MARKS_LAYER } from "./layers";

const POINTS = 2400;
/** Numbers per point: x y z (m), time (s), and length of the path so far (m). */
const FLOATS = 5;
/** With more changed ranges than this the whole buffer is uploaded. */
const MOST_RANGES = 32;
/** A new point must be at least this far from the last one, m. */
const SPACING_M = 0.01;
const WIDTH_PX = 2.2;
/** Length of one dash and one gap of a dashed line, m. */
const DASH_M = 0.06;
/** Opacity of the oldest part of a trail of unlimited length. */
const FAINTEST = 0.25;

const VERTEX = /* glsl */ `
uniform vec2 halfPixel; uniform float widthPx;
attribute vec3 a; attribute vec2 aWhen; attribute vec3 b; attribute vec2 bWhen;
varying float vTime; varying float vWay;
void main() {
  vec4 ca = projectionMatrix * viewMatrix * vec4(a, 1.0);
  vec4 cb = projectionMatrix * viewMatrix * vec4(b, 1.0);
  vec2 along = (cb.xy / cb.w - ca.xy / ca.w) / halfPixel;
  along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
  vec4 here = position.x < 0.5 ? ca : cb;
  vec2 out2 = vec2(-along.y, along.x) * position.y + along * (position.x - 0.5);
  here.xy += out2 * widthPx * halfPixel * here.w;
  vTime = position.x < 0.5 ? aWhen.x : bWhen.x;
  vWay = position.x < 0.5 ? aWhen.y : bWhen.y;
  gl_Position = (ca.w < 0.02 || cb.w < 0.02) ? vec4(2.0, 2.0, 2.0, 1.0) : here;
}`;
const FRAGMENT = /* glsl */ `
uniform vec3 color; uniform float now; uniform float span; uniform float dash; uniform float fade;
varying float vTime; varying float vWay;
void main() {
  if (dash > 0.0 && fract(vWay / dash) > 0.6) discard;
  float age = (now - vTime) / span;
  if (age > 1.0) discard;
  gl_FragColor = vec4(color, 1.0 - age * fade);
  #include <colorspace_fragment>
}`;

export class Trail {
  readonly line: Mesh<InstancedBufferGeometry, ShaderMaterial>;
  private readonly points = new Float32Array(POINTS * FLOATS);
  private readonly buffer = new InstancedInterleavedBuffer(this.points, FLOATS);
  private count = 0;
  private firstTime = 0;
  private newestTime = 0;
  private span = Infinity;

  constructor(color: ColorRepresentation, dashed: boolean) {
    const geometry = new InstancedBufferGeometry();
    const corners = new BufferGeometry();
    corners.setAttribute("position", new Float32BufferAttribute([0, 1, 0, 0, -1, 0, 1, 1, 0, 1, -1, 0], 3));
    geometry.setAttribute("position", corners.getAttribute("position"));
    geometry.setIndex([0, 1, 2, 2, 1, 3]);
    const part = (size: number, offset: number): InterleavedBufferAttribute => new InterleavedBufferAttribute(this.buffer, size, offset);
    geometry.setAttribute("a", part(3, 0)).setAttribute("aWhen", part(2, 3));
    geometry.setAttribute("b", part(3, FLOATS)).setAttribute("bWhen", part(2, FLOATS + 3));
    geometry.instanceCount = 0;
    const uniforms = {
      color: { value: new Color(color) },
      halfPixel: { value: new Vector2(0.001, 0.001) },
      widthPx: { value: WIDTH_PX / 2 },
      now: { value: 0 },
      span: { value: 1 },
      fade: { value: 1 - FAINTEST },
      dash: { value: dashed ? DASH_M : 0 },
    };
    this.line = new Mesh(geometry, new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms, transparent: true, depthWrite: false }));
    this.line.frustumCulled = false;
    this.line.layers.set(MARKS_LAYER);
  }

  /** Takes the size of the picture, CSS px. */
  resize(width: number, height: number): void {
    (this.line.material.uniforms["halfPixel"]?.value as Vector2).set(2 / width, 2 / height);
  }

  recolor(color: ColorRepresentation): void {
    (this.line.material.uniforms["color"]?.value as Color).set(color);
  }

  /** Sets the time by which the trail reaches back, s. */
  setSpan(span: number): void {
    this.span = span;
    const { fade } = this.line.material.uniforms;
    if (fade !== undefined) fade.value = Number.isFinite(span) ? 1 : 1 - FAINTEST;
    this.age();
  }

  get length(): number {
    return this.count;
  }

  /** Adds the position (x, y, z), m, which the body had at `time`, s. */
  add(x: number, y: number, z: number, time: number): void {
    if (!Number.isFinite(x + y + z)) return;
    const last = (this.count - 1) * FLOATS;
    const step = this.count === 0 ? 0 : Math.hypot(x - this.at(last), y - this.at(last + 1), z - this.at(last + 2));
    if (this.count > 0 && step < SPACING_M) return;
    if (this.count === POINTS - 1) this.thin();
    const k = this.count * FLOATS;
    const way = this.count === 0 ? 0 : this.at(k - FLOATS + 4) + step;
    this.write(k, x, y, z, time, way);
    this.count += 1;
    if (this.count === 1) this.firstTime = time;
  }

  /** Moves the end of the line to (x, y, z), m, where the body is at `time`, s. */
  end(x: number, y: number, z: number, time: number): void {
    if (this.count === 0 || !Number.isFinite(x + y + z)) return;
    const k = this.count * FLOATS;
    const step = Math.hypot(x - this.at(k - FLOATS), y - this.at(k - FLOATS + 1), z - this.at(k - FLOATS + 2));
    this.write(k, x, y, z, time, this.at(k - FLOATS + 4) + step);
    this.newestTime = time;
    this.line.geometry.instanceCount = this.count;
    this.age();
  }

  clear(): void {
    this.count = 0;
    this.line.geometry.instanceCount = 0;
  }

  private write(k: number, x: number, y: number, z: number, time: number, way: number): void {
    this.points[k] = x;
    this.points[k + 1] = y;
    this.points[k + 2] = z;
    this.points[k + 3] = time;
    this.points[k + 4] = way;
    this.changed(k, FLOATS);
  }

  /** Marks these numbers for upload with the next picture. The number of ranges is bounded, also while the line is not drawn. */
  private changed(from: number, count: number): void {
    const { buffer } = this;
    if (buffer.updateRanges.length >= MOST_RANGES) {
      buffer.clearUpdateRanges();
      buffer.addUpdateRange(0, this.points.length);
    } else buffer.addUpdateRange(from, count);
    buffer.needsUpdate = true;
  }

  /** Drops the oldest quarter of the points to make room. */
  private thin(): void {
    const gone = POINTS >> 2;
    this.points.copyWithin(0, gone * FLOATS, this.count * FLOATS);
    this.changed(0, this.points.length);
    this.count -= gone;
    this.firstTime = this.at(3);
  }

  private age(): void {
    const { uniforms } = this.line.material;
    if (uniforms["now"] !== undefined) uniforms["now"].value = this.newestTime;
    if (uniforms["span"] !== undefined) uniforms["span"].value = Number.isFinite(this.span) ? this.span : Math.max(1, this.newestTime - this.firstTime);
  }

  private at(index: number): number {
    return this.points[index] ?? NaN;
  }
}
