import { Matrix4, PerspectiveCamera, Quaternion, Vector2, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import type { Scene, SceneBody } from "../protocol";
import { Bodies } from "./bodies";
import { Picker } from "./pick";

const WIDTH = 800;
const HEIGHT = 500;
const canvas = { getBoundingClientRect: () => ({ left: 100, top: 50, width: WIDTH, height: HEIGHT }) } as HTMLElement;

function cube(name: string, group: SceneBody["group"], position: [number, number, number]): SceneBody {
  const shape = { shape: { kind: "box" as const, size_m: [0.1, 0.1, 0.1] as [number, number, number] }, position: [0, 0, 0.2] as [number, number, number], quaternion_wxyz: [1, 0, 0, 0] as [number, number, number, number], rgba: [1, 0, 0, 1] as [number, number, number, number] };
  return { name, group, moving: group !== "arena", pose: { position, quaternion_wxyz: [1, 0, 0, 0] }, shapes: [shape] };
}

const scene: Scene = { bodies: [cube("base", "vehicle", [0, 0, 1]), cube("table", "arena", [0.6, 0.2, 1]), cube("behind", "payload", [0, 2, 1])], rotors: [], base_body: "base" };

function setUp(): { picker: Picker; bodies: Bodies; camera: PerspectiveCamera } {
  const camera = new PerspectiveCamera(40, WIDTH / HEIGHT, 0.02, 200);
  camera.up.set(0, 0, 1);
  camera.position.set(0, -4, 1.2);
  camera.lookAt(0, 0, 1.2);
  camera.updateMatrixWorld();
  const bodies = new Bodies(scene, "#00ff00", "#888888");
  bodies.root.updateMatrixWorld(true);
  return { picker: new Picker(camera, canvas), bodies, camera };
}

/** Position of a world point on the page, by the formula of the pinhole camera. */
function pinhole(x: number, y: number, z: number): [number, number] {
  const f = 1 / Math.tan((20 * Math.PI) / 180);
  const depth = y + 4;
  return [100 + ((f * x * HEIGHT) / WIDTH / depth + 1) * (WIDTH / 2), 50 + (1 - (f * (z - 1.2)) / depth) * (HEIGHT / 2)];
}

describe("Picker", () => {
  it("finds where a world point is on the page, as a pinhole camera does", () => {
    const { picker } = setUp();
    const [x, y] = picker.onPage(new Vector3(0.6, 0.2, 1.3));
    const [wantedX, wantedY] = pinhole(0.6, 0.2, 1.3);
    expect(x).toBeCloseTo(wantedX, 6);
    expect(y).toBeCloseTo(wantedY, 6);
  });

  it("picks the nearest body under the cursor, and nothing beside it", () => {
    const { picker, bodies } = setUp();
    const at = (x: number, y: number, z: number): string | undefined => picker.pick(bodies, picker.ndc(...pinhole(x, y, z), new Vector2()))?.body.name;
    expect(at(0, 0, 1.2)).toBe("base");
    expect(at(0.6, 0.2, 1.2)).toBe("table");
    expect(at(0.3, 0, 1.2)).toBeUndefined();
  });

  it("meets a body on its surface", () => {
    const { picker, bodies } = setUp();
    const hit = picker.pick(bodies, picker.ndc(...pinhole(0, -0.05, 1.21), new Vector2()));
    expect(hit?.point.distanceTo(new Vector3(0, -0.05, 1.21))).toBeLessThan(1e-6);
  });

  it("grabs the vehicle from close beside it, and never anything else", () => {
    const { picker, bodies } = setUp();
    const grab = (x: number, y: number): string | undefined => picker.grab(bodies, picker.ndc(x, y, new Vector2()), x, y)?.body.name;
    const [x, y] = pinhole(0, 0, 1.2);
    expect(grab(x, y)).toBe("base");
    expect(grab(x + 35, y)).toBe("base");
    expect(grab(x + 60, y)).toBeUndefined();
    expect(grab(...pinhole(0.6, 0.2, 1.2))).toBeUndefined();
  });

  it("knows the box of a body in its own frame", () => {
    const { bodies } = setUp();
    const { box } = bodies.body("base")!;
    const turned = new Matrix4().compose(new Vector3(0, 0, 1), new Quaternion(), new Vector3(1, 1, 1));
    expect(box.clone().applyMatrix4(turned).getCenter(new Vector3()).distanceTo(new Vector3(0, 0, 1.2))).toBeLessThan(1e-6);
  });
});
