// The keys of the playhead. They are the same for a live flight, a mirrored recording and an exported page.
import { commands } from "../panels/commands";
import type { View } from "../plots/view";
import type { TimeBar } from "./bar";
import type { Transport } from "./transport";

const GROUP = "Time";
const STEP_S = 0.1;
const LONG_STEP_S = 1;

export interface TimeTarget {
  bar: TimeBar;
  view: View;
  transport(): Transport;
  tickS(): number;
  /** Tells the values at the playhead after a key has moved it. */
  moved(): void;
}

export function registerTimeKeys({ bar, view, transport, tickS, moved }: TimeTarget): void {
  const by = (id: string, key: string, description: string, seconds: () => number): void => {
    const action = (): void => {
      transport().step(seconds());
      moved();
    };
    // On a live flight that is not in the past, the keys to the right fly the vehicle on.
    const when = (): boolean => seconds() < 0 || !transport().live || transport().past;
    commands.register({ id: `time.${id}`, group: GROUP, description, keys: [key], action, when, repeats: true });
  };
  by("back", "ArrowLeft", "100 ms back", () => -STEP_S);
  by("on", "ArrowRight", "100 ms on", () => STEP_S);
  by("far-back", "Shift+ArrowLeft", "1 s back", () => -LONG_STEP_S);
  by("far-on", "Shift+ArrowRight", "1 s on", () => LONG_STEP_S);
  by("tick-back", "Ctrl+ArrowLeft", "one tick back", () => -tickS());
  by("tick-on", "Ctrl+ArrowRight", "one tick on", () => tickS());
  const act = (id: string, keys: string[], description: string, action: () => void): void => {
    commands.register({
      id: `time.${id}`, group: GROUP, description, keys,
      action: () => {
        action();
        moved();
      },
    });
  };
  act("start", ["Home"], "to the oldest moment", () => transport().seek(transport().oldestS));
  act("live", ["End"], "to the newest moment: live again", () => transport().toNewest());
  act("event-before", ["["], "to the event before", () => bar.toEvent(-1));
  act("event-after", ["]"], "to the event after", () => bar.toEvent(1));
  act("hold", ["P"], "hold this moment, or follow the flight again", () => (transport().past ? transport().toNewest() : transport().toggle()));
  act("type", ["Shift+J"], "type a time", () => bar.typeTime());
  act("loop", ["Shift+O"], "play the range from I to O, else all, again and again", () => transport().toggleLoop());
  commands.register(
    { id: "time.play", group: GROUP, description: "in the past: play or stop", keys: ["Space"], action: () => transport().toggle(), when: () => transport().past },
    { id: "time.escape", group: GROUP, description: "leave the zoom, then the past", keys: ["Escape"], keyOnly: true, action: () => void view.back(), when: () => view.inspecting && document.querySelector(":popover-open") === null },
  );
}
