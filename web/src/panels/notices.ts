// Short messages to this operator, for example about a refused gain. Errors stay until the operator closes them. Notices have
// their own place above the event log, so they cover nothing.
import type { NoticeLevel } from "../protocol";
import { byId, element } from "./dom";

const STAYS_MS = 6000;
const SHOWN_AT_MOST = 4;
const ICONS: Record<NoticeLevel, string> = { info: "ℹ", warning: "△", error: "▲" };

export function notify(level: NoticeLevel, text: string): void {
  const root = byId("notices");
  const same = [...root.children].find((child) => child.querySelector("p")?.textContent === text);
  same?.remove();
  const body = element("p", { textContent: text });
  const close = element("button", { textContent: "✕", ariaLabel: "Close this message" });
  const notice = element("div", { className: "notice" }, [element("span", { textContent: ICONS[level], ariaHidden: "true" }), body, close]);
  notice.dataset["level"] = level;
  close.addEventListener("click", () => notice.remove());
  root.append(notice);
  while (root.childElementCount > SHOWN_AT_MOST) root.firstElementChild?.remove();
  if (level !== "error") window.setTimeout(() => notice.remove(), STAYS_MS);
}
