// Camera buttons over the 3-D view.
import type { CameraMode } from "../scene/camera";
import type { World } from "../scene/world";
import { byId } from "./dom";

export interface CameraActions {
  overview(): void;
  follow(): void;
  top(): void;
  hand(): void;
  /** Shows which camera is in use. */
  show(): void;
}

const MODES = ["overview", "follow", "top"] as const;

/** Connects the buttons; returns their actions. */
export function cameraButtons(world: () => World | null): CameraActions {
  const buttons = MODES.map((mode) => ({ mode, button: byId(`camera-${mode}`) }));
  const hand = byId("camera-hand");
  const show = (): void => {
    buttons.forEach(({ mode, button }) => (button.ariaPressed = String(world()?.mode === mode)));
    hand.ariaPressed = String(world()?.handShown ?? false);
  };
  const choose = (mode: CameraMode) => (): void => {
    const shown = world();
    if (shown !== null) shown.mode = mode;
    show();
  };
  const toggleHand = (): void => {
    const shown = world();
    if (shown !== null) shown.handShown = !shown.handShown;
    show();
  };
  buttons.forEach(({ mode, button }) => button.addEventListener("click", choose(mode)));
  hand.addEventListener("click", toggleHand);
  show();
  return { overview: choose("overview"), follow: choose("follow"), top: choose("top"), hand: toggleHand, show };
}
