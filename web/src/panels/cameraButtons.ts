// Camera buttons over the 3-D view.
import type { World } from "../scene/world";
import { byId } from "./dom";

/** Connects the buttons; returns the action of "Fit". */
export function cameraButtons(world: World | null): () => void {
  const follow = byId("camera-follow");
  const orbit = byId("camera-orbit");
  const show = (): void => {
    follow.ariaPressed = String(world?.mode === "follow");
    orbit.ariaPressed = String(world?.mode === "orbit");
  };
  const choose = (mode: World["mode"]): void => {
    if (world !== null) world.mode = mode;
    show();
  };
  const fit = (): void => {
    world?.fit();
    show();
  };
  follow.addEventListener("click", () => choose("follow"));
  orbit.addEventListener("click", () => choose("orbit"));
  byId("camera-fit").addEventListener("click", fit);
  choose(matchMedia("(prefers-reduced-motion: reduce)").matches ? "orbit" : "follow");
  return fit;
}
