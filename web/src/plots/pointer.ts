// The pointer over a chart. It moves the shared cursor; a drag zooms; a wheel zooms with Ctrl and pans with Shift.
import type { View } from "./view";

/** A shorter movement is a click, px. */
const DRAG_FROM_PX = 5;
const WHEEL_ZOOM = 1.2;
const WHEEL_PAN = 0.1;

export interface PointerActions {
  /** Takes the stretch that a drag has selected so far, as parts of the width; null when the drag is over. */
  select(part: [number, number] | null): void;
  /** Takes the event of the pointer over the chart; null when the pointer has left. */
  hover(event: PointerEvent | null): void;
  click(event: PointerEvent): void;
}

export function listenPointer(over: HTMLElement, view: View, actions: PointerActions): void {
  const partOf = (clientX: number): number => {
    const { left, width } = over.getBoundingClientRect();
    return Math.min(1, Math.max(0, (clientX - left) / Math.max(1, width)));
  };
  let downX: number | null = null;
  let dragging = false;
  const end = (): void => {
    downX = null;
    dragging = false;
    actions.select(null);
  };
  over.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || event.ctrlKey) return;
    downX = event.clientX;
    over.setPointerCapture(event.pointerId);
  });
  over.addEventListener("pointermove", (event) => {
    view.pointer = partOf(event.clientX);
    actions.hover(event);
    if (downX === null) return;
    dragging ||= Math.abs(event.clientX - downX) >= DRAG_FROM_PX;
    if (dragging) actions.select(ordered(partOf(downX), partOf(event.clientX)));
  });
  over.addEventListener("pointerup", (event) => {
    if (downX !== null && dragging) {
      const [from, to] = view.span();
      const [a, b] = ordered(partOf(downX), partOf(event.clientX));
      view.zoom(from + a * (to - from), from + b * (to - from));
    } else if (downX !== null) {
      actions.click(event);
    }
    end();
    if (event.pointerType === "touch") leave();
  });
  over.addEventListener("pointercancel", end);
  const leave = (): void => {
    view.pointer = null;
    actions.hover(null);
  };
  over.addEventListener("pointerleave", leave);
  over.addEventListener("dblclick", () => view.unzoom());
  over.addEventListener("wheel", (event) => wheel(event, partOf(event.clientX), view), { passive: false });
}

function wheel(event: WheelEvent, part: number, view: View): void {
  const way = Math.sign(event.deltaY === 0 ? event.deltaX : event.deltaY);
  if (way === 0 || !(event.ctrlKey || event.shiftKey)) return;
  event.preventDefault();
  const [from, to] = view.span();
  if (event.ctrlKey) view.scale(way > 0 ? WHEEL_ZOOM : 1 / WHEEL_ZOOM, part);
  else view.pan(way * WHEEL_PAN * (to - from));
}

function ordered(a: number, b: number): [number, number] {
  return a <= b ? [a, b] : [b, a];
}

/** Listens to drags of the timeline under the charts, which pan the stretch shown. */
export function listenPan(strip: HTMLElement, view: View, widthOf: () => number, actions: Omit<PointerActions, "select">): void {
  let last: number | null = null;
  let moved = 0;
  strip.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    last = event.clientX;
    moved = 0;
    strip.setPointerCapture(event.pointerId);
  });
  strip.addEventListener("pointermove", (event) => {
    actions.hover(event);
    if (last === null) return;
    moved += Math.abs(event.clientX - last);
    if (moved < DRAG_FROM_PX) return;
    const [from, to] = view.span();
    view.pan((-(event.clientX - last) / Math.max(1, widthOf())) * (to - from));
    last = event.clientX;
  });
  strip.addEventListener("pointerup", (event) => {
    if (last !== null && moved < DRAG_FROM_PX) actions.click(event);
    last = null;
  });
  strip.addEventListener("pointerleave", () => actions.hover(null));
  strip.addEventListener("wheel", (event) => wheel(event, 0.5, view), { passive: false });
}
