// What does not depend on the flight: renderer, light, floor grid and axes.
import { AxesHelper, Color, DirectionalLight, GridHelper, HemisphereLight, type LineBasicMaterial, Mesh, MeshBasicMaterial, PlaneGeometry, Scene, WebGLRenderer } from "three";
import type { Palette } from "../panels/theme";

const FLOOR_M = 20;
const LARGEST_PIXEL_RATIO = 2;

/** WebGL works without a graphics card here: every pixel costs processor time. */
function isSoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (gl === null) return true;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = String(gl.getParameter(info === null ? gl.RENDERER : info.UNMASKED_RENDERER_WEBGL));
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /SwiftShader|llvmpipe|Software/i.test(name);
}

/** Sky, floor and the lines on it. */
export type StageColors = Pick<Palette, "sky" | "ground3d" | "floor">;

export interface Stage {
  renderer: WebGLRenderer;
  scene: Scene;
  software: boolean;
  setColors(colors: StageColors): void;
}

export function buildStage(canvas: HTMLCanvasElement): Stage {
  // Antialias is chosen before the renderer can be asked what it is, so a throw-away context is asked.
  const software = isSoftware();
  const renderer = new WebGLRenderer({ canvas, antialias: !software, powerPreference: "high-performance" });
  renderer.setPixelRatio(software ? 1 : Math.min(LARGEST_PIXEL_RATIO, window.devicePixelRatio));
  const scene = new Scene();
  const sun = new DirectionalLight(0xffffff, 1.9);
  sun.position.set(-3, -4, 8);
  scene.add(sun, new HemisphereLight(0xffffff, 0x8a8f96, 1.7));
  const grid = new GridHelper(FLOOR_M, FLOOR_M * 2);
  grid.rotation.x = Math.PI / 2;
  grid.position.z = 0.001;
  const axes = new AxesHelper(0.4);
  axes.setColors("#d6453d", "#4a9e46", "#3f7fd0");
  axes.position.z = 0.002;
  const floor = new Mesh(new PlaneGeometry(FLOOR_M, FLOOR_M), new MeshBasicMaterial());
  scene.add(floor, grid, axes);
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
  return { renderer, scene, software, setColors };
}
