// Tabs by the ARIA pattern: one tab is chosen, arrow keys move within the list, and each tab has its panel.
import { remembered } from "./remembered";

export interface Tabs {
  show(id: string): void;
  readonly shown: string;
}

/**
 * Wires the `[role=tab]` buttons in `list`; each names its panel in `aria-controls`. `changed` is called with the id of the chosen
 * tab. The choice is remembered under `key`.
 */
export function startTabs(list: HTMLElement, key: string, changed: (id: string) => void = () => {}): Tabs {
  const tabs = [...list.querySelectorAll<HTMLButtonElement>("[role=tab]")];
  const choice = remembered(key, tabs[0]?.id ?? "");
  const show = (id: string): void => {
    const known = tabs.some((tab) => tab.id === id) ? id : (tabs[0]?.id ?? "");
    choice.set(known);
    tabs.forEach((tab) => {
      const chosen = tab.id === known;
      tab.ariaSelected = String(chosen);
      tab.tabIndex = chosen ? 0 : -1;
      const panel = document.getElementById(tab.getAttribute("aria-controls") ?? "");
      if (panel !== null && panel.role === "tabpanel") panel.hidden = !chosen;
    });
    changed(known);
  };
  tabs.forEach((tab, index) => {
    tab.addEventListener("click", () => show(tab.id));
    tab.addEventListener("keydown", (event) => {
      const to = { ArrowRight: index + 1, ArrowLeft: index - 1, Home: 0, End: tabs.length - 1 }[event.key];
      if (to === undefined || event.ctrlKey) return;
      event.preventDefault();
      const next = tabs[(to + tabs.length) % tabs.length];
      next?.focus();
      next?.click();
    });
  });
  show(choice.get());
  return {
    show,
    get shown() {
      return choice.get();
    },
  };
}
