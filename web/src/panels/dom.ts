// Small helpers over the DOM.

/** The element with this id. Throws if the page lacks it, which happens if page and script have different versions. */
export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no element #${id}`);
  return found as T;
}

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Partial<HTMLElementTagNameMap[K]> = {},
  children: (Node | string)[] = [],
): HTMLElementTagNameMap[K] {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

export function option(value: string, label: string, selected = false): HTMLOptionElement {
  return element("option", { value, textContent: label, selected });
}

/** Writes text only when it changed, so that screen readers and layout are left alone. */
export function setText(target: HTMLElement, text: string): void {
  if (target.textContent !== text) target.textContent = text;
}

export interface Choice {
  value: string;
  label: string;
}

/** Fills `root` with buttons, one of which is chosen; arrow keys move within the group. */
export function radioGroup(root: HTMLElement, choices: Choice[], chosen: string, choose: (value: string) => void): void {
  const buttons = choices.map(({ value, label }) => element("button", { textContent: label, value, role: "radio" }));
  const mark = (selected: string): void => {
    buttons.forEach((button) => {
      button.ariaChecked = String(button.value === selected);
      button.tabIndex = button.value === selected ? 0 : -1;
    });
  };
  buttons.forEach((button, index) => {
    button.addEventListener("click", () => {
      mark(button.value);
      choose(button.value);
    });
    button.addEventListener("keydown", (event) => {
      const by = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
      if (by === 0 || event.ctrlKey) return;
      event.preventDefault();
      const next = buttons[(index + by + buttons.length) % buttons.length];
      next?.focus();
      next?.click();
    });
  });
  mark(chosen);
  root.replaceChildren(...buttons);
}
