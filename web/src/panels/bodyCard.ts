// The card of the body that was chosen in the 3-D view: its name, pose, speed and contact force.
import type { Store } from "../data/store";
import { type BodyReading, readingOf } from "../scene/reading";
import type { World } from "../scene/world";
import { byId, element, setText } from "./dom";

const UNKNOWN = "unknown";

interface Row {
  label: string;
  text(reading: BodyReading): string | null;
}

const ROWS: Row[] = [
  { label: "group", text: ({ group }) => group },
  { label: "mass", text: ({ massKg }) => (massKg === null ? null : `${massKg.toFixed(3)} kg`) },
  { label: "x y z", text: ({ position }) => numbers(position, 3, 6, "m") },
  { label: "φ θ ψ", text: ({ rollPitchYaw }) => numbers(rollPitchYaw, 1, 6, "°") },
  { label: "velocity", text: ({ velocity }) => numbers(velocity, 2, 5, "m/s") },
  { label: "speed", text: ({ velocity }) => number(Math.hypot(...velocity), 2, "m/s") },
  { label: "contact", text: ({ contactN, contactPoints }) => (contactPoints === 0 ? "none" : `${contactN.toFixed(1)} N at ${contactPoints} point${contactPoints === 1 ? "" : "s"}`) },
  { label: "off reference", text: ({ offReferenceM }) => (offReferenceM === null ? null : number(offReferenceM, 3, "m")) },
];

export class BodyCard {
  private readonly root = byId("body-card");
  private readonly title = element("h3", {});
  private readonly list = element("dl", {});
  private shownName: string | null = null;
  private values: { row: Row; output: HTMLElement }[] = [];

  constructor(
    private readonly world: World,
    private readonly store: Store,
  ) {
    const close = element("button", { textContent: "✕", title: "Close (Esc)", ariaLabel: "Choose no body" });
    close.addEventListener("click", () => world.choose(undefined));
    this.root.replaceChildren(element("header", {}, [this.title, close]), this.list);
  }

  /** Writes the newest values of the body. */
  readings(): void {
    const body = this.world.chosenBody;
    this.root.hidden = body === undefined;
    if (body === undefined) {
      this.shownName = null;
      return;
    }
    const reading = readingOf(this.world, body, this.store.state);
    if (this.shownName !== body.name) this.lay(body.name, reading);
    this.values.forEach(({ row, output }) => setText(output, row.text(reading) ?? UNKNOWN));
  }

  /** Lays out the lines whose values this body has. The choice of lines stays as long as the body is chosen. */
  private lay(name: string, reading: BodyReading): void {
    this.shownName = name;
    setText(this.title, name);
    this.values = ROWS.filter((row) => row.text(reading) !== null).map((row) => ({ row, output: element("dd", {}) }));
    this.list.replaceChildren(...this.values.flatMap(({ row, output }) => [element("dt", { textContent: row.label }), output]));
  }
}

/** Values of `width` characters each, so that the text does not jump when they change. */
function numbers(values: number[], digits: number, width: number, unit: string): string {
  return values.every(Number.isFinite) ? `${values.map((value) => fixed(value, digits, width)).join("  ")} ${unit}` : UNKNOWN;
}

function number(value: number, digits: number, unit: string): string {
  return Number.isFinite(value) ? `${fixed(value, digits, 0)} ${unit}` : UNKNOWN;
}

/** A number of constant width for either sign, and without a minus sign before zero. */
function fixed(value: number, digits: number, width: number): string {
  const text = value.toFixed(digits);
  const plain = Number(text) === 0 ? (0).toFixed(digits) : text;
  return plain.replace("-", "−").padStart(width, "\u2007");
}
