// The text of a mark, beside the pointer.
import { byId, element } from "../panels/dom";
import { type Cluster, markKind } from "./clusters";

const MOST_LINES = 5;

export class MarkTip {
  private readonly root = byId("mark-tip");
  private shown: Cluster | null = null;

  /** Shows the texts of `cluster` at a position in the window, px; null hides them. */
  show(cluster: Cluster | null, clientX: number, clientY: number): void {
    if (cluster === null) {
      this.root.hidden = true;
      this.shown = null;
      return;
    }
    if (cluster !== this.shown) this.fill(cluster);
    this.shown = cluster;
    this.root.hidden = false;
    const frame = this.root.parentElement?.getBoundingClientRect() ?? new DOMRect();
    const box = this.root.getBoundingClientRect();
    const x = Math.min(frame.width - box.width - 4, Math.max(4, clientX - frame.left - box.width / 2));
    const above = clientY - frame.top - box.height - 12;
    this.root.style.transform = `translate(${Math.round(x)}px, ${Math.round(above > 0 ? above : clientY - frame.top + 16)}px)`;
  }

  private fill({ marks }: Cluster): void {
    const lines = marks.slice(0, MOST_LINES).map(({ kind, text, time }) => element("p", {}, [`${markKind(kind).icon} ${time.toFixed(2)} s `, element("span", { textContent: text })]));
    if (marks.length > MOST_LINES) lines.push(element("p", { className: "muted", textContent: `and ${marks.length - MOST_LINES} more` }));
    this.root.replaceChildren(...lines);
  }
}
