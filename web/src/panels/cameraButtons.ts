// Camera buttons over the 3-D view.
import type { CameraMode } from "../scene/camera";
import type { World } from "../scene/world";
import { byId } from "./dom";

export interface CameraActions {
  overview(): void;
  follow(): void;
  hand(): void;
  /** Shows which camera is in use. */
  show(): void;
}

/** Connects the buttons; returns what they do. */
export function cameraButtons(world: () => World | null): CameraActions {
  const overview = byId("camera-overview");
  const follow = byId("camera-follow");
  const hand = byId("camera-hand");
  const show = (): void => {
    overview.ariaPressed = String(world()?.mode === "overview");
    follow.ariaPressed = String(world()?.mode === "follow");
    hand.ariaPressed = String(world()?.handShown ?? false);
  };
  const choose = (mode: CameraMode): void => {
    const shown = world();
    if (shown !== null) shown.mode = mode;
    show();
  };
  const actions = {
    overview: () => choose("overview"),
    follow: () => choose("follow"),
    hand: () => {
      const shown = world();
      if (shown !== null) shown.handShown = !shown.handShown;
      show();
    },
    show,
  };
  overview.addEventListener("click", actions.overview);
  follow.addEventListener("click", actions.follow);
  hand.addEventListener("click", actions.hand);
  show();
  return actions;
}
