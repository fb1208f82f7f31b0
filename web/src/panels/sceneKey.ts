// The legend of the 3-D view: the meaning of each colour shown, the scale of the arrows, and the newest values.
import { METRES_PER_NEWTON } from "../scene/forces";
import type { World } from "../scene/world";
import { byId, element, setText } from "./dom";
import { ARROW_KINDS, type KindInfo, MARK_KINDS } from "./viewKinds";

const SCALE_CM = 10;
/** Kinds whose newest value stands beside their name, N. */
const VALUED = ["total_thrust", "estimate", "adapter"] as const;
type Valued = (typeof VALUED)[number];

export class SceneKey {
  private readonly root = byId("scene-key");
  private readonly values = new Map<Valued, HTMLElement>();

  /** `unit` gives the unit of the forces: per kilogram if the mass of a mirrored vehicle is unknown. */
  constructor(
    private readonly world: World,
    private readonly unit: () => string,
  ) {}

  /** Shows the legend of the kinds that are drawn now. */
  show(): void {
    const { shown } = this.world.settings;
    this.values.clear();
    const inSight = (info: KindInfo): boolean => shown[info.kind] && info.brief !== undefined && info.kind !== "wind";
    const items = [...MARK_KINDS, ...ARROW_KINDS].filter(inSight).map((info) => this.item(info));
    const proportional = ARROW_KINDS.some(({ kind }) => shown[kind] && kind !== "contact" && kind !== "wind");
    const newtons = SCALE_CM / 100 / METRES_PER_NEWTON;
    const scale = [...(proportional ? [`${SCALE_CM} cm = ${newtons.toFixed(0)} ${this.unit()}`] : []), ...(shown.contact ? ["contact by √N"] : [])];
    if (scale.length > 0) items.push(element("li", { className: "muted", textContent: scale.join(", ") }));
    this.root.hidden = items.length === 0;
    this.root.replaceChildren(...items);
    this.readings();
  }

  /** Writes the newest values. */
  readings(): void {
    const newtons = this.world.forcesNow();
    this.values.forEach((output, kind) => setText(output, Number.isFinite(newtons[kind]) ? `${newtons[kind].toFixed(1)} ${this.unit()}` : "unknown"));
  }

  private item({ kind, brief, help, mark }: KindInfo): HTMLElement {
    const item = element("li", { title: help }, [element("i", { className: `line ${mark ?? ""}` }), brief ?? ""]);
    const valued = VALUED.find((known) => known === kind);
    if (valued === undefined) return item;
    const output = element("output", { textContent: "" });
    item.append(output);
    this.values.set(valued, output);
    return item;
  }
}
