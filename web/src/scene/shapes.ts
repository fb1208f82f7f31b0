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
import type { ScenePose, SceneShape, ShapeInfo } from "../protocol";

const ROUND_SEGMENTS = 24;

export function geometryOf(shape: SceneShape): BufferGeometry {
  switch (shape.kind) {
    case "box":
      return new BoxGeometry(...shape.size_m);
    case "cylinder":
      return new CylinderGeometry(shape.radius_m, shape.radius_m, shape.length_m, ROUND_SEGMENTS).rotateX(Math.PI / 2);
    case "sphere":
      return new SphereGeometry(shape.radius_m, ROUND_SEGMENTS, ROUND_SEGMENTS / 2);
    case "capsule":
      return new CapsuleGeometry(shape.radius_m, shape.length_m, 6, ROUND_SEGMENTS).rotateX(Math.PI / 2);
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

/** Frees what the graphics card holds for `root`. */
export function dispose(root: Object3D): void {
  root.traverse((object) => {
    const mesh = object as Partial<Mesh>;
    mesh.geometry?.dispose();
    const materials = mesh.material === undefined ? [] : [mesh.material].flat();
    materials.forEach((material) => material.dispose());
  });
}
