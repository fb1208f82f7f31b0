// The colours of the page against WCAG 2.2: 4.5:1 for text (1.4.3), 3:1 for lines, marks and edges of controls (1.4.11).
import { describe, expect, it } from "vitest";
import css from "./tokens.css?raw";

const TEXT = 4.5;
const GRAPHIC = 3;
/** The colours of the lines of forks. */
const FORKS = Array.from({ length: 6 }, (_, k) => `fork-${k + 1}`);
const SURFACES = ["ground", "panel", "raised"];

function theme(name: "dark" | "light"): Map<string, string> {
  const block = new RegExp(`data-theme="${name}"\\]\\s*\\{([^}]*)\\}`).exec(css)?.[1] ?? "";
  return new Map([...block.matchAll(/--([\w-]+):\s*(#[0-9a-f]{6})/g)].map(([, key, value]) => [key ?? "", value ?? ""]));
}

/** Relative luminance by the formula of WCAG 2.2. */
function luminance(hex: string): number {
  const [r = 0, g = 0, b = 0] = [1, 3, 5].map((at) => {
    const channel = parseInt(hex.slice(at, at + 2), 16) / 255;
    return channel <= 0.04045 ? channel / 12.92 : ((channel + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

function contrast(a: string, b: string): number {
  const [light = 0, dark = 0] = [luminance(a), luminance(b)].sort((x, y) => y - x);
  return (light + 0.05) / (dark + 0.05);
}

describe("contrast", () => {
  it("is computed as in WCAG's own examples", () => {
    expect(contrast("#000000", "#ffffff")).toBeCloseTo(21, 5);
    expect(contrast("#777777", "#ffffff")).toBeCloseTo(4.48, 2);
  });

  for (const name of ["dark", "light"] as const) {
    const colors = theme(name);
    const pairs = (inks: string[], surfaces: string[]): [string, string][] => inks.flatMap((ink) => surfaces.map((surface): [string, string] => [ink, surface]));
    const failing = (list: [string, string][], least: number): string[] =>
      list.flatMap(([ink, surface]) => {
        const [a, b] = [colors.get(ink), colors.get(surface)];
        const ratio = a === undefined || b === undefined ? 0 : contrast(a, b);
        return ratio >= least ? [] : [`${ink} on ${surface}: ${ratio.toFixed(2)}`];
      });

    it(`of every text is at least 4.5:1, ${name}`, () => {
      expect(failing([...pairs(["ink", "muted", "good", "warn", "bad"], SURFACES), ["on-accent", "accent"], ["ink", "selected"], ["muted", "selected"]], TEXT)).toEqual([]);
    });

    it(`of every line, mark, focus ring and edge of a control is at least 3:1, ${name}`, () => {
      expect(failing([...pairs(["estimate", "setpoint", "third", "fourth", "focus", "control", ...FORKS], SURFACES)], GRAPHIC)).toEqual([]);
    });
  }
});
