// What does not depend on the flight: renderer, light and floor grid.
import { Color, DirectionalLight, GridHelper, HemisphereLight, type LineBasicMaterial, Mesh, MeshBasicMaterial, PlaneGeometry, Scene, type WebGLRenderer } from "three";
import type { Palette } from "../panels/theme";
import { directSurface, isSoftware, SoftwareSurface, type Surface } from "./surface";

const FLOOR_M = 20;
const LARGEST_PIXEL_RATIO = 2;
/** Pixels that a processor draws 30 times a second and still has time for charts; more are drawn coarser. */
const SOFTWARE_PIXELS = 400_000;

/** Pixels drawn per CSS pixel of a view of this size. */
export function pixelRatio(software: boolean, width: number, height: number, screen: number): number {
  return software ? Math.min(1, Math.sqrt(SOFTWARE_PIXELS / (width * height))) : Math.min(LARGEST_PIXEL_RATIO, screen);
}

/** Sky, floor and the lines on it. */
export type StageColors = Pick<Palette, "sky" | "ground3d" | "floor">;

export interface Stage {
  renderer: WebGLRenderer;
  surface: Surface;
  scene: Scene;
  software: boolean;
  resize(width: number, height: number): void;
  setColors(colors: StageColors): void;
}

export function buildStage(canvas: HTMLCanvasElement): Stage {
  // What the surface shall be is known before its renderer can be asked, so a throw-away context is asked.
  const software = isSoftware();
  const surface = software ? new SoftwareSurface(canvas) : directSurface(canvas);
  const { renderer } = surface;
  const scene = new Scene();
  const sun = new DirectionalLight(0xffffff, 1.9);
  sun.position.set(-3, -4, 8);
  scene.add(sun, new HemisphereLight(0xffffff, 0x8a8f96, 1.7));
  const grid = new GridHelper(FLOOR_M, FLOOR_M * 2);
  grid.rotation.x = Math.PI / 2;
  grid.position.z = 0.001;
  const floor = new Mesh(new PlaneGeometry(FLOOR_M, FLOOR_M), new MeshBasicMaterial());
  scene.add(floor, grid);
  const setColors = (colors: StageColors): void => {
    scene.background = new Color(colors.sky);
    floor.material.color.set(colors.ground3d);
    const material = grid.material as LineBasicMaterial;
    material.vertexColors = false;
    material.color.set(colors.floor);
    material.transparent = true;
    material.opacity = 0.55;
    material.needsUpdate = true;
  };
  const resize = (width: number, height: number): void => {
    renderer.setPixelRatio(pixelRatio(software, width, height, window.devicePixelRatio));
    renderer.setSize(width, height, false);
  };
  return { renderer, surface, scene, software, resize, setColors };
}
