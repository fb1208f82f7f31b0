// The panel for a restart with a seed, under the small arrow beside Restart.
import { byId, setText } from "./dom";
import { hang } from "./popover";

/** Upper limit of the seeds of "new seed". It is small, so that an operator can type such a seed again. */
const SEEDS = 1_000_000;

/** `restart` restarts the flight with a seed; null keeps the seed in use. */
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
