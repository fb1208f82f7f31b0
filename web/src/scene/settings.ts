// The operator's settings of the 3-D view. The browser keeps them from one visit to the next.

export const ARROWS = ["thrust", "total_thrust", "estimate", "adapter", "contact", "wind"] as const;
export type ArrowKind = (typeof ARROWS)[number];
export const FRAMES = ["world", "body", "links", "tool", "payload"] as const;
export type FrameKind = (typeof FRAMES)[number];
export const MARKS = ["trail", "reference_trail", "ghost"] as const;
export type MarkKind = (typeof MARKS)[number];
export type ViewKind = ArrowKind | FrameKind | MarkKind;

/** Choices for the length of the trails, s of simulated time; the last one is unlimited. */
export const TRAIL_SPANS_S = [5, 15, 60, Infinity] as const;

export interface ViewSettings {
  shown: Record<ViewKind, boolean>;
  trailS: number;
}

const STORED = "twin.view";
const FIRST: Record<ViewKind, boolean> = {
  thrust: true,
  total_thrust: false,
  estimate: false,
  adapter: false,
  contact: true,
  wind: true,
  world: true,
  body: false,
  links: false,
  tool: false,
  payload: false,
  trail: true,
  reference_trail: true,
  ghost: true,
};
const FIRST_TRAIL_S = 60;

export function firstSettings(): ViewSettings {
  return { shown: { ...FIRST }, trailS: FIRST_TRAIL_S };
}

/** Settings from stored text; a missing or invalid setting has its value of the first visit. */
export function parseSettings(text: string | null): ViewSettings {
  const settings = firstSettings();
  let stored: unknown;
  try {
    stored = JSON.parse(text ?? "null");
  } catch {
    return settings;
  }
  if (typeof stored !== "object" || stored === null) return settings;
  const { shown, trail_s } = stored as { shown?: unknown; trail_s?: unknown };
  if (typeof shown === "object" && shown !== null) {
    for (const kind of Object.keys(FIRST) as ViewKind[]) {
      const on = (shown as Record<string, unknown>)[kind];
      if (typeof on === "boolean") settings.shown[kind] = on;
    }
  }
  const span = trail_s === "all" ? Infinity : trail_s;
  if (TRAIL_SPANS_S.some((known) => known === span)) settings.trailS = span as number;
  return settings;
}

export function settingsText({ shown, trailS }: ViewSettings): string {
  return JSON.stringify({ shown, trail_s: Number.isFinite(trailS) ? trailS : "all" });
}

export function loadSettings(): ViewSettings {
  return parseSettings(localStorage.getItem(STORED));
}

export function saveSettings(settings: ViewSettings): void {
  localStorage.setItem(STORED, settingsText(settings));
}
