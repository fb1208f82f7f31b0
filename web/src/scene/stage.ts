// The parts of the 3-D view that do not depend on the flight: renderer, light and floor grid.
import { Color, DirectionalLight, GridHelper, HemisphereLight, LineSegments, Mesh, PlaneGeometry, Scene, ShaderMaterial, type WebGLRenderer } from "three";
import type { Palette } from "../panels/theme";
import { directSurface, isSoftware, SoftwareSurface, type Surface } from "./surface";

const FLOOR_M = 20;
const LINES_ALPHA = 0.55;
const LARGEST_PIXEL_RATIO = 2;
/** Most pixels that a processor draws 30 times a second with time left for charts; a larger view is drawn with fewer pixels. */
const SOFTWARE_PIXELS = 400_000;

/** Pixels drawn per CSS pixel along each axis, for a view of this size. */
export function pixelRatio(software: boolean, width: number, height: number, screen: number): number {
  return software ? Math.min(1, Math.sqrt(SOFTWARE_PIXELS / (width * height))) : Math.min(LARGEST_PIXEL_RATIO, screen);
}

/**
 * A material of one colour, already in the encoding of the screen. Other materials encode the colour of every pixel. For a floor
 * that fills the picture a processor would need longer for this than for the rest of the picture.
 */
function flatMaterial(opacity: number): ShaderMaterial {
  return new ShaderMaterial({
    uniforms: { color: { value: new Color() }, alpha: { value: opacity } },
    vertexShader: "void main() { gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }",
    fragmentShader: "uniform vec3 color; uniform float alpha; void main() { gl_FragColor = vec4(color, alpha); }",
    transparent: opacity < 1,
  });
}

function paint({ uniforms }: ShaderMaterial, color: string): void {
  (uniforms["color"]?.value as Color).set(color).convertLinearToSRGB();
}

/** Colours of the sky, the floor and the lines on the floor. */
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
  // The kind of the surface must be known before its renderer exists, so a temporary context tells it.
  const software = isSoftware();
  const surface = software ? new SoftwareSurface(canvas) : directSurface(canvas);
  const { renderer } = surface;
  const scene = new Scene();
  const sun = new DirectionalLight(0xffffff, 1.9);
  sun.position.set(-3, -4, 8);
  scene.add(sun, new HemisphereLight(0xffffff, 0x8a8f96, 1.7));
  const lines = flatMaterial(LINES_ALPHA);
  const grid = new LineSegments(new GridHelper(FLOOR_M, FLOOR_M * 2).geometry, lines);
  grid.rotation.x = Math.PI / 2;
  grid.position.z = 0.001;
  const floor = new Mesh(new PlaneGeometry(FLOOR_M, FLOOR_M), flatMaterial(1));
  scene.add(floor, grid);
  const setColors = (colors: StageColors): void => {
    scene.background = new Color(colors.sky);
    paint(floor.material, colors.ground3d);
    paint(lines, colors.floor);
  };
  const resize = (width: number, height: number): void => {
    renderer.setPixelRatio(pixelRatio(software, width, height, window.devicePixelRatio));
    renderer.setSize(width, height, false);
  };
  return { renderer, surface, scene, software, resize, setColors };
}
