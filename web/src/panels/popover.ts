// Small panels below a button. The browser opens and closes them (popover, popovertarget); this module places them under the
// button and inside the window.

const MARGIN_PX = 8;

/** Places `panel` under `button` whenever it opens; `opened` fills it. */
export function hang(panel: HTMLElement, button: HTMLElement, opened: () => void = () => {}): void {
  const place = (): void => {
    if (!isOpen(panel)) return;
    const anchor = button.getBoundingClientRect();
    const { offsetWidth: width, offsetHeight: height } = panel;
    const left = Math.min(anchor.left, innerWidth - width - MARGIN_PX);
    const top = Math.min(anchor.bottom + 6, innerHeight - height - MARGIN_PX);
    panel.style.left = `${Math.max(MARGIN_PX, left)}px`;
    panel.style.top = `${Math.max(MARGIN_PX, top)}px`;
  };
  panel.addEventListener("beforetoggle", (event) => {
    const open = (event as ToggleEvent).newState === "open";
    button.ariaExpanded = String(open);
    if (!open) return;
    opened();
    // The size of the panel is not known yet, but the position of its button is.
    const { left, bottom } = button.getBoundingClientRect();
    panel.style.left = `${left}px`;
    panel.style.top = `${bottom + 6}px`;
  });
  panel.addEventListener("toggle", place);
  window.addEventListener("resize", place);
}

export function isOpen(panel: HTMLElement): boolean {
  return panel.matches(":popover-open");
}
