// The dark or the light theme: the system chooses it until the operator does. Drawing on a canvas needs the colours as values.
import { tokenReader } from "../style/tokens";

export interface Palette {
  ink: string;
  muted: string;
  grid: string;
  estimate: string;
  setpoint: string;
  third: string;
  fourth: string;
  sky: string;
  floor: string;
  ground3d: string;
  panel: string;
  focus: string;
  warn: string;
}

const STORED = "twin.theme";
type Theme = "dark" | "light";

function isTheme(text: string | null): text is Theme {
  return text === "dark" || text === "light";
}

export function readPalette(): Palette {
  const value = tokenReader();
  return {
    ink: value("ink"),
    muted: value("muted"),
    grid: value("grid"),
    estimate: value("estimate"),
    setpoint: value("setpoint"),
    third: value("third"),
    fourth: value("fourth"),
    sky: value("sky"),
    floor: value("floor"),
    ground3d: value("ground-3d"),
    panel: value("panel"),
    focus: value("focus"),
    warn: value("warn"),
  };
}

/** Applies the theme and calls `changed` at every later change. */
export function startTheme(button: HTMLElement, changed: (palette: Palette) => void): void {
  const system = matchMedia("(prefers-color-scheme: light)");
  const stored = localStorage.getItem(STORED);
  let chosen: Theme | null = isTheme(stored) ? stored : null;
  const apply = (): void => {
    document.documentElement.dataset["theme"] = chosen ?? (system.matches ? "light" : "dark");
  };
  const update = (): void => {
    apply();
    changed(readPalette());
  };
  apply();
  system.addEventListener("change", update);
  button.addEventListener("click", () => {
    chosen = document.documentElement.dataset["theme"] === "dark" ? "light" : "dark";
    localStorage.setItem(STORED, chosen);
    update();
  });
}
