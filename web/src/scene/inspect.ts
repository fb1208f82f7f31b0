// The values of the 3-D view that a browser test may read. They are the values as drawn, and a test cannot change them.
import { Vector3 } from "three";
import type { DrawnArrow } from "./arrow";
import { METRES_PER_METRE_PER_SECOND, METRES_PER_NEWTON } from "./forces";
import type { ViewSettings } from "./settings";
import type { World } from "./world";

export interface SceneHooks {
  mode: string;
  /** Whether the camera is moving to another position. */
  moving: boolean;
  camera: { position: number[]; target: number[]; up_in_picture: number[] };
  /** Position of the centre of each body's box on the page, CSS px. */
  on_page: Record<string, [number, number]>;
  chosen: string | null;
  hovered: string | null;
  shown: ViewSettings["shown"];
  arrows: Record<string, DrawnArrow>;
  contacts: DrawnArrow[];
  frames: string[];
  trail_points: number;
  /** Force of the current push, N; null without a push. */
  push_n: number[] | null;
  m_per_n: number;
  m_per_m_s: number;
  render_ms: number;
  /** Number of pictures drawn since the page was loaded. */
  pictures: number;
}

export function inspect(world: World): SceneHooks {
  const { arrows, contacts, frames, trail } = world.overlays.drawn();
  const { camera } = world.view;
  camera.updateMatrixWorld();
  const places = (world.bodies?.list() ?? []).map(({ name, object, box }): [string, [number, number]] => {
    object.updateWorldMatrix(true, false);
    return [name, world.picker.onPage(box.getCenter(new Vector3()).applyMatrix4(object.matrixWorld))];
  });
  return {
    mode: world.mode,
    moving: world.view.moving,
    camera: { position: camera.position.toArray(), target: world.view.target.toArray(), up_in_picture: new Vector3().setFromMatrixColumn(camera.matrixWorld, 1).toArray() },
    on_page: Object.fromEntries(places),
    chosen: world.chosenBody?.name ?? null,
    hovered: world.overlays.hovered.body?.name ?? null,
    shown: { ...world.settings.shown },
    arrows,
    contacts,
    frames,
    trail_points: trail,
    push_n: world.pointer.pushing ? world.pointer.spring.force.toArray() : null,
    m_per_n: METRES_PER_NEWTON,
    m_per_m_s: METRES_PER_METRE_PER_SECOND,
    pictures: world.pictures,
    render_ms: world.renderMs,
  };
}
