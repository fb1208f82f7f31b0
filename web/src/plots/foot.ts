// The line under the charts. It tells whether the charts follow the flight or are inspected, always in the same place.
import { byId, setText } from "../panels/dom";
import type { View } from "./view";

export class ChartFoot {
  private readonly button = byId("inspect");
  private readonly text = byId("inspect-text");
  private readonly root = byId("charts-foot");

  constructor(private readonly view: View) {
    this.button.addEventListener("click", () => (view.inspecting ? view.live() : view.hold()));
  }

  show(now: number): void {
    const { view } = this;
    const cursor = view.cursor();
    this.root.dataset["mode"] = view.inspecting ? "inspecting" : "live";
    this.button.ariaPressed = String(view.inspecting);
    setText(this.button, view.inspecting ? "▶ Back to live" : "❚❚ Inspect");
    setText(this.text, view.inspecting ? `${view.zoomed ? "zoomed, " : ""}inspecting ${place(view, cursor)} · live is at ${now.toFixed(2)} s` : liveText(cursor, now));
  }
}

function place(view: View, cursor: number | null): string {
  const [from, to] = view.span();
  return cursor === null ? `${from.toFixed(2)} s to ${to.toFixed(2)} s` : `${cursor.toFixed(2)} s`;
}

function liveText(cursor: number | null, now: number): string {
  return cursor === null ? `live at ${now.toFixed(1)} s` : `cursor at ${cursor.toFixed(2)} s · live at ${now.toFixed(1)} s`;
}
