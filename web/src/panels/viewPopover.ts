// The list behind "View": the things to draw, the chosen body, and buttons that push the vehicle without a mouse.
import { Vector3 } from "three";
import { TRAIL_SPANS_S, type ViewKind } from "../scene/settings";
import type { World } from "../scene/world";
import { capsOf } from "./chord";
import { byId, element, option } from "./dom";
import { ARROW_KINDS, FRAME_KINDS, type KindInfo, MARK_KINDS } from "./viewKinds";

const PUSH_N = 5;
const PUSH_S = 0.3;
const DIRECTIONS: [string, Vector3][] = [
  ["−x", new Vector3(-1, 0, 0)],
  ["+x", new Vector3(1, 0, 0)],
  ["−y", new Vector3(0, -1, 0)],
  ["+y", new Vector3(0, 1, 0)],
  ["−z", new Vector3(0, 0, -1)],
  ["+z", new Vector3(0, 0, 1)],
];

export class ViewPopover {
  private readonly root = byId("view");
  private readonly opener = byId("view-open");
  private readonly boxes = new Map<ViewKind, HTMLInputElement>();
  private readonly bodies = element("select", { id: "view-body" });
  private readonly pushes: HTMLButtonElement[];

  constructor(
    private readonly world: World,
    private readonly changed: () => void,
  ) {
    this.pushes = DIRECTIONS.map(([label, way]) => {
      const button = element("button", { textContent: label, title: `Push by ${PUSH_N} N for ${PUSH_S} s towards ${label} of the world` });
      button.addEventListener("click", () => this.world.push(way.clone().multiplyScalar(PUSH_N), PUSH_S));
      return button;
    });
    this.bodies.addEventListener("change", () => this.world.choose(this.bodies.value === "" ? undefined : this.bodies.value));
    this.root.replaceChildren(
      this.group("Arrows", ARROW_KINDS.map((info) => this.row(info))),
      this.group("Ways", [...MARK_KINDS.map((info) => this.row(info)), this.trailRow()]),
      this.group("Axes", [element("div", { className: "view-axes" }, FRAME_KINDS.map((info) => this.row(info)))]),
      this.group("Chosen body", [element("label", { className: "view-body" }, [this.bodies, keyCap("N")])]),
      this.group(`Push ${PUSH_N} N for ${PUSH_S} s`, [element("div", { className: "view-push" }, this.pushes)]),
    );
    this.root.addEventListener("toggle", () => this.place());
    window.addEventListener("resize", () => this.place());
  }

  toggle(): void {
    this.root.togglePopover();
  }

  /** Takes another flight with other bodies. */
  rebuild(): void {
    const names = this.world.bodies?.list().map(({ name }) => name) ?? [];
    this.bodies.replaceChildren(option("", "none"), ...names.map((name) => option(name, name)));
    this.show();
  }

  /** Shows the settings in the controls. */
  show(): void {
    this.boxes.forEach((box, kind) => (box.checked = this.world.settings.shown[kind]));
    this.bodies.value = this.world.chosenBody?.name ?? "";
  }

  /** Enables the push buttons only while a flight runs. */
  readings(): void {
    this.pushes.forEach((button) => (button.disabled = !this.world.pushable));
  }

  private group(title: string, rows: Node[]): HTMLElement {
    return element("fieldset", {}, [element("legend", { textContent: title }), ...rows]);
  }

  private row({ kind, label, help, key, mark }: KindInfo): HTMLElement {
    const box = element("input", { type: "checkbox", id: `view-${kind}`, checked: this.world.settings.shown[kind] });
    box.addEventListener("change", () => {
      this.world.settings.shown[kind] = box.checked;
      this.changed();
    });
    this.boxes.set(kind, box);
    const line = mark === undefined ? [] : [element("i", { className: `line ${mark}` })];
    return element("label", { title: help }, [box, element("span", {}, [...line, label]), ...(key === undefined ? [] : [keyCap(key)])]);
  }

  private trailRow(): HTMLElement {
    const select = element("select", { id: "view-span" });
    select.append(...TRAIL_SPANS_S.map((span) => option(String(span), Number.isFinite(span) ? `last ${span} s` : "unlimited", span === this.world.settings.trailS)));
    select.addEventListener("change", () => {
      this.world.settings.trailS = Number(select.value);
      this.changed();
    });
    return element("label", { className: "view-trail" }, [element("span", { textContent: "Length of the paths" }), select]);
  }

  private place(): void {
    const open = this.root.matches(":popover-open");
    this.opener.ariaExpanded = String(open);
    if (!open) return;
    const { right, bottom } = this.opener.getBoundingClientRect();
    this.root.style.top = `${Math.max(4, Math.min(bottom + 4, window.innerHeight - this.root.offsetHeight - 4))}px`;
    this.root.style.left = `${Math.max(4, right - this.root.offsetWidth)}px`;
  }
}

function keyCap(key: string): HTMLElement {
  return element("span", { className: "keys" }, capsOf(key).map((cap) => element("kbd", { textContent: cap === "Shift" ? "⇧" : cap })));
}
