// Restart with a seed: the panel under the small arrow beside Restart.
import { byId, setText } from "./dom";
import { hang } from "./popover";

/** Seeds of "new seed": small enough to be typed again. */
const SEEDS = 1_000_000;

/** `restart` flies with a seed, or with the one in use for null. */
export function startRestart(seedInUse: () => number | undefined, restart: (seed: number | null) => void): void {
  const panel = byId("restart-panel");
  const field = byId<HTMLInputElement>("seed");
  hang(panel, byId("restart-more"), () => {
    const seed = seedInUse();
    setText(byId("seed-now"), seed === undefined ? "unknown" : String(seed));
  });
  byId("seed-new").addEventListener("click", () => {
    field.value = String(Math.floor(Math.random() * SEEDS));
  });
  byId<HTMLFormElement>("restart-form").addEventListener("submit", (event) => {
    event.preventDefault();
    const seed = field.value === "" ? null : field.valueAsNumber;
    restart(seed);
    panel.hidePopover();
  });
}
