// Keeps the whole page at one moment: the store, from which every panel reads, and the 3-D view stand where the playhead stands.
import type { Store } from "../data/store";
import { byId, setText } from "../panels/dom";
import type { View } from "../plots/view";
import type { ScenePlayer } from "../scene/player";
import type { Transport } from "./transport";

export class Moment {
  private shownTick: number | null = null;
  private past = false;
  private readonly banner = byId("picture-banner");

  /** `changed` is called when the page enters or leaves the past. */
  constructor(
    private readonly store: Store,
    private readonly view: View,
    private readonly scene: ScenePlayer,
    private readonly changed: (past: boolean) => void,
  ) {}

  /** Whether the page shows a moment before the newest one of a flight that goes on. */
  get isPast(): boolean {
    return this.past;
  }

  /** Shows the moment at the playhead; called in each frame. Returns whether the moment has changed. */
  frame(transport: Transport): boolean {
    const { history } = this.store;
    const { pinned } = this.view;
    const tick = pinned === null || history.length === 0 ? null : Math.min(history.last, Math.max(history.first, this.store.tickAt(pinned)));
    this.store.playhead = tick;
    if (tick === this.shownTick) return false;
    this.shownTick = tick;
    if (this.past !== transport.past) {
      this.past = transport.past;
      this.changed(this.past);
    }
    if (tick === null) {
      this.banner.hidden = true;
      this.scene.live();
      return true;
    }
    this.banner.hidden = this.scene.show(tick);
    if (!this.banner.hidden) setText(this.banner, "This page has no picture of this moment: it was opened later. Charts, numbers and events are those of this moment.");
    return true;
  }
}
