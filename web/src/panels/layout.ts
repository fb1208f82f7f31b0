// The layouts of the page: which of its parts have how much room. The choice is kept; an address that ends with a layout's name, such as
// `#tune`, opens the page in it.
import { commands } from "./commands";
import { byId, option } from "./dom";
import { remembered } from "./remembered";

export const LAYOUTS = [
  { name: "fly", help: "the vehicle first; of the gains only those changed or starred" },
  { name: "tune", help: "3-D view, charts and every gain" },
  { name: "adapt", help: "the charts of residual and adapter first" },
  { name: "replay", help: "3-D view and charts, without gains" },
] as const;
export type Layout = (typeof LAYOUTS)[number]["name"];

/** The layout that `word` names; null if there is none. */
export function layoutOf(word: string): Layout | null {
  return LAYOUTS.find(({ name }) => name === word)?.name ?? null;
}

/** Connects the choice of the layout; `changed` is called with each choice and at once with the first. */
export function startLayout(changed: (layout: Layout) => void): void {
  const select = byId<HTMLSelectElement>("layout");
  const kept = remembered<string>("twin.layout", "fly");
  select.append(...LAYOUTS.map(({ name, help }) => Object.assign(option(name, name), { title: help })));
  const choose = (layout: Layout): void => {
    kept.set(layout);
    select.value = layout;
    document.body.dataset["layout"] = layout;
    changed(layout);
  };
  select.addEventListener("change", () => choose(layoutOf(select.value) ?? "fly"));
  commands.register(
    ...LAYOUTS.map(({ name, help }) => ({ id: `page.layout.${name}`, group: "Page", description: `layout ${name}: ${help}`, keys: [], action: () => choose(name) })),
  );
  choose(layoutOf(location.hash.slice(1)) ?? layoutOf(kept.get()) ?? "fly");
}
