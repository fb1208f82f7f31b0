// The list under the button "Charts", in which the operator chooses the charts and marks to show.
import { EVENT_KINDS } from "../data/eventKinds";
import { byId, element } from "../panels/dom";
import type { Arrangement, OwnChart } from "./arrangement";

export interface MenuActions {
  /** Saves and shows the new choice. */
  changed(): void;
  edit(own: OwnChart): void;
  add(): void;
  reset(): void;
  saveCsv(): void;
  savePng(): void;
  clearMarkers(): void;
}

export interface MenuChart {
  key: string;
  title: string;
}

export class ChartMenu {
  private readonly root = byId("charts-options");

  constructor(private readonly actions: MenuActions) {
    const button = byId("charts-menu");
    this.root.addEventListener("beforetoggle", () => {
      const { right, bottom } = button.getBoundingClientRect();
      Object.assign(this.root.style, { top: `${bottom + 4}px`, right: `${Math.max(8, document.documentElement.clientWidth - right)}px` });
    });
  }

  /** Lists `charts`; the operator's own charts get a button to edit them. */
  rebuild(charts: MenuChart[], arrangement: Arrangement): void {
    const { actions } = this;
    const shown = charts.map(({ key, title }) => {
      const own = arrangement.own.find((candidate) => candidate.key === key);
      const edit = element("button", { textContent: "Channels…", className: "small" });
      edit.addEventListener("click", () => own !== undefined && actions.edit(own));
      return element("li", {}, [toggle(title, arrangement.hidden, key, actions), ...(own === undefined ? [] : [edit])]);
    });
    const marks = EVENT_KINDS.map(({ kind, icon, label }) => element("li", {}, [toggle(`${icon} ${label}`, arrangement.unmarked, kind, actions)]));
    const button = (textContent: string, action: () => void): HTMLButtonElement => {
      const made = element("button", { textContent });
      made.addEventListener("click", action);
      return made;
    };
    const scrolled = this.root.scrollTop;
    this.root.replaceChildren(
      element("h3", { textContent: "Charts" }),
      element("ul", {}, shown),
      button("New chart…", actions.add),
      element("h3", { textContent: "Marks on the charts" }),
      element("ul", { className: "two" }, marks),
      element("h3", { textContent: "Save what is in view" }),
      element("div", { className: "menu-foot" }, [
        Object.assign(button("CSV", actions.saveCsv), { id: "save-csv", title: "Every tick in view of every channel shown, as CSV" }),
        Object.assign(button("PNG", actions.savePng), { id: "save-png", title: "A picture of the charts" }),
      ]),
      element("div", { className: "menu-foot" }, [button("Clear my marks", actions.clearMarkers), button("Reset to default", actions.reset)]),
    );
    this.root.scrollTop = scrolled;
  }
}

/** A check box that is ticked while `key` is not in the list `off`. */
function toggle(text: string, off: string[], key: string, actions: MenuActions): HTMLLabelElement {
  const box = element("input", { type: "checkbox", checked: !off.includes(key), value: key });
  box.addEventListener("change", () => {
    const at = off.indexOf(key);
    if (box.checked && at >= 0) off.splice(at, 1);
    else if (!box.checked && at < 0) off.push(key);
    actions.changed();
  });
  return element("label", {}, [box, ` ${text}`]);
}
