// Coordinate axes of frames: X is red with one ring at its end, Y green with two rings, Z blue with three. Each frame has its name.
import { BoxGeometry, type BufferGeometry, Color, Float32BufferAttribute, Group, Mesh, MeshBasicMaterial, type Object3D, Vector3 } from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import type { Palette } from "../panels/theme";
import { Label } from "./label";
import { MARKS_LAYER } from "./layers";
import { FRAMES, type FrameKind, type ViewSettings } from "./settings";

/** Thickness of an axis of length 1 m, m. */
const THICKNESS_M = 0.026;
const COLORS = ["#d6453d", "#4a9e46", "#3f7fd0"];
/** Rings on an axis of length 1 m, m: position of the first, distance to the next, and size. They tell axes apart without colours. */
const RING_M = { first: 0.95, next: 0.1, size: 0.07, length: 0.04 };
const LENGTH_M: Record<FrameKind, number> = { world: 0.4, body: 0.3, links: 0.1, tool: 0.12, payload: 0.12 };

/** The names of small frames that are close together appear only within this distance of the camera, m. */
const NAMED_WITHIN_M = 3;
const CLOSE_TOGETHER: FrameKind[] = ["links", "tool"];

export interface FrameHolder {
  kind: FrameKind;
  name: string;
  object: Object3D;
}

/** A box along an axis, from `from` to `to`. */
function piece(axis: number, from: number, to: number, size: number, color: Color): BufferGeometry {
  const sides: [number, number, number] = [size, size, size];
  sides[axis] = to - from;
  const box = new BoxGeometry(...sides);
  const middle: [number, number, number] = [0, 0, 0];
  middle[axis] = (from + to) / 2;
  box.translate(...middle);
  const corners = box.getAttribute("position").count;
  box.setAttribute("color", new Float32BufferAttribute(Array.from({ length: corners }, () => color.toArray()).flat(), 3));
  return box;
}

function axesGeometry(): BufferGeometry {
  const pieces = COLORS.flatMap((name, axis) => {
    const color = new Color(name);
    const rings = Array.from({ length: axis + 1 }, (_, k) => RING_M.first - k * RING_M.next);
    return [piece(axis, 0, 1, THICKNESS_M, color), ...rings.map((at) => piece(axis, at, at + RING_M.length, RING_M.size, color))];
  });
  return mergeGeometries(pieces);
}

export class Frames {
  private readonly geometry = axesGeometry();
  private readonly material = new MeshBasicMaterial({ vertexColors: true, depthTest: false, transparent: true });
  private readonly place = new Vector3();
  private alone = true;
  /** Material of the world's axes, which bodies may hide. The axes of a body are inside the body and show through it. */
  private readonly solid = new MeshBasicMaterial({ vertexColors: true });
  private readonly made: { kind: FrameKind; root: Group; label: Label }[];

  constructor(holders: FrameHolder[], palette: Palette, shown: ViewSettings["shown"]) {
    this.made = holders.map(({ kind, name, object }) => {
      const root = new Group();
      const axes = new Mesh(this.geometry, kind === "world" ? this.solid : this.material);
      if (kind === "world") axes.layers.set(MARKS_LAYER);
      axes.scale.setScalar(LENGTH_M[kind]);
      axes.renderOrder = 2;
      const label = new Label(name, palette.ink, palette.panel);
      root.add(axes, label.sprite);
      object.add(root);
      return { kind, root, label };
    });
    this.apply(shown);
  }

  apply(shown: ViewSettings["shown"]): void {
    // The axes of the world need no name while no other axes are shown.
    this.alone = FRAMES.every((kind) => kind === "world" || !shown[kind]);
    for (const { kind, root } of this.made) root.visible = shown[kind];
  }

  /** Shows the names that are readable from `eye`, in the world, m; call it before drawing. */
  seenFrom(eye: Vector3): void {
    for (const { kind, root, label } of this.made) {
      if (!root.visible) continue;
      const near = !CLOSE_TOGETHER.includes(kind) || this.place.setFromMatrixPosition(root.matrixWorld).distanceTo(eye) < NAMED_WITHIN_M;
      label.sprite.visible = near && (kind !== "world" || !this.alone);
    }
  }

  /** Takes the height of the picture, CSS px. */
  resize(height: number): void {
    this.made.forEach(({ label }) => label.resize(height));
  }

  recolor(palette: Palette): void {
    this.made.forEach(({ label }) => label.recolor(palette.ink, palette.panel));
  }

  /** Kinds of frames that are drawn now, for tests. */
  drawn(): string[] {
    return [...new Set(this.made.filter(({ root }) => root.visible).map(({ kind }) => kind))];
  }

  dispose(): void {
    this.made.forEach(({ root, label }) => {
      root.removeFromParent();
      label.dispose();
    });
    this.geometry.dispose();
    this.material.dispose();
    this.solid.dispose();
  }
}
