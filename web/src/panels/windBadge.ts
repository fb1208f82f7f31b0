// The wind as a dial. Its arrow turns with the picture, and up means away from the operator.
import { METRES_PER_METRE_PER_SECOND } from "../scene/forces";
import type { World } from "../scene/world";
import { byId, setText } from "./dom";

/** A weaker wind counts as calm, m/s. */
const CALM_M_S = 0.05;

/** Angle of the dial's arrow, degrees clockwise from up, for wind (`x`, `y`) and a camera that looks along `heading`, rad. */
export function dialDeg(x: number, y: number, heading: number): number {
  return ((heading - Math.atan2(y, x)) * 180) / Math.PI;
}

export class WindBadge {
  private readonly root = byId("wind");
  private readonly arrow = byId<HTMLElement>("wind-arrow");
  private readonly text = byId("wind-text");

  constructor(private readonly world: World) {}

  readings(): void {
    const [x, y, z] = this.world.windNow();
    const speed = Math.hypot(x, y, z);
    this.root.hidden = !this.world.settings.shown.wind || !Number.isFinite(speed);
    if (this.root.hidden) return;
    const calm = speed < CALM_M_S;
    this.arrow.style.visibility = calm ? "hidden" : "visible";
    this.arrow.style.transform = `rotate(${dialDeg(x, y, this.world.view.heading).toFixed(0)}deg)`;
    setText(this.text, calm ? "calm" : `${speed.toFixed(1)} m/s`);
    this.root.title = `Wind at the vehicle: ${[x, y, z].map((v) => v.toFixed(1)).join(", ")} m/s in world x, y, z. Its arrows: ${(METRES_PER_METRE_PER_SECOND * 100).toFixed(0)} cm for 1 m/s`;
  }
}
