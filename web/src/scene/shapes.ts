// Three.js geometry for the shapes the server describes. World and bodies are z-up; cylinders and capsules lie along z.
import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  Color,
  CylinderGeometry,
  DoubleSide,
  FrontSide,
  type Material,
  Mesh,
  MeshLambertMaterial,
  type Object3D,
  SphereGeometry,
  SRGBColorSpace,
} from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import type { ScenePose, SceneShape, ShapeInfo } from "../protocol";

/** Number of sides of a round shape of this radius, m. Small shapes get few sides, because a software renderer pays for each. */
const sides = (radius: number): number => (radius < 0.02 ? 12 : radius < 0.05 ? 16 : 24);

export function geometryOf(shape: SceneShape): BufferGeometry {
  switch (shape.kind) {
    case "box":
      return new BoxGeometry(...shape.size_m);
    case "cylinder":
      return new CylinderGeometry(shape.radius_m, shape.radius_m, shape.length_m, sides(shape.radius_m)).rotateX(Math.PI / 2);
    case "sphere":
      return new SphereGeometry(shape.radius_m, sides(shape.radius_m), sides(shape.radius_m) / 2);
    case "capsule":
      return new CapsuleGeometry(shape.radius_m, shape.length_m, 4, sides(shape.radius_m)).rotateX(Math.PI / 2);
    case "mesh":
      return meshGeometry(shape.vertices, shape.triangles);
  }
}

function meshGeometry(vertices: number[][], triangles: number[][]): BufferGeometry {
  const indexed = new BufferGeometry();
  indexed.setAttribute("position", new BufferAttribute(Float32Array.from(vertices.flat()), 3));
  indexed.setIndex(new BufferAttribute(Uint32Array.from(triangles.flat()), 1));
  const flat = indexed.toNonIndexed();
  indexed.dispose();
  flat.computeVertexNormals();
  return flat;
}

/** Puts `object` at `pose`. */
export function place(object: Object3D, { position, quaternion_wxyz: [w, x, y, z] }: ScenePose): void {
  object.position.set(...position);
  object.quaternion.set(x, y, z, w);
}

export function materialOf([r, g, b, a]: ShapeInfo["rgba"], twoSided: boolean): MeshLambertMaterial {
  const color = new Color().setRGB(r, g, b, SRGBColorSpace);
  return new MeshLambertMaterial({
    color,
    opacity: a,
    transparent: a < 1,
    depthWrite: a >= 1,
    side: twoSided ? DoubleSide : FrontSide,
  });
}

export function meshOf(info: ShapeInfo, material?: Material): Mesh {
  const mesh = new Mesh(geometryOf(info.shape), material ?? materialOf(info.rgba, info.shape.kind === "mesh"));
  place(mesh, info);
  return mesh;
}

/**
 * The meshes of one body. All opaque shapes become a single mesh with a colour per corner. A vehicle of sixty shapes is then drawn
 * in eight calls, which matters because a software renderer spends its time on calls.
 */
export function meshesOf(shapes: ShapeInfo[]): Mesh[] {
  const plain = shapes.filter(({ shape, rgba }) => shape.kind !== "mesh" && rgba[3] >= 1);
  const others = shapes.filter((info) => !plain.includes(info)).map((info) => meshOf(info));
  if (plain.length === 0) return others;
  const merged = mergeGeometries(plain.map(coloured));
  return [new Mesh(merged, new MeshLambertMaterial({ vertexColors: true })), ...others];
}

/** Geometry of a shape in the body's frame, with the shape's colour at every corner. */
function coloured(info: ShapeInfo): BufferGeometry {
  const made = meshOf(info);
  made.updateMatrix();
  const { geometry } = made;
  geometry.applyMatrix4(made.matrix);
  geometry.deleteAttribute("uv");
  const { r, g, b } = (made.material as MeshLambertMaterial).color;
  const colors = new Float32Array(geometry.getAttribute("position").count * 3);
  for (let i = 0; i < colors.length; i += 3) colors.set([r, g, b], i);
  geometry.setAttribute("color", new BufferAttribute(colors, 3));
  return geometry;
}

/** Frees the memory of the graphics card for `root` and all its children. */
export function dispose(root: Object3D): void {
  root.traverse((object) => {
    const mesh = object as Partial<Mesh>;
    mesh.geometry?.dispose();
    const materials = mesh.material === undefined ? [] : [mesh.material].flat();
    materials.forEach((material) => material.dispose());
  });
}
