// Makes 2-D canvases fast without a graphics card. There a canvas without the option `willReadFrequently` goes through the software
// rasteriser and slows the page down: 6 frames/s against 42 with five charts. The browser also copies and composes a canvas of the
// page in every frame, even if nothing was drawn on it. It copies a canvas whose control was transferred only after drawing.

type Pen = CanvasRenderingContext2D;
type GetContext = (this: HTMLCanvasElement, kind: string, options?: object) => RenderingContext | null;

const pens = new WeakMap<HTMLCanvasElement, Pen>();
let patched = false;
/** Whether canvases that now get a context will be shown on the page. */
let shown = false;

/** Sets `willReadFrequently` for every 2-D context that is created from now on. Call it before the first chart is made. */
export function preferProcessorCanvas(): void {
  if (patched) return;
  patched = true;
  const { prototype } = HTMLCanvasElement;
  const get = prototype.getContext as GetContext;
  const marking: GetContext = function (kind, options) {
    if (kind !== "2d") return get.call(this, kind, options);
    return shown ? handedOver(this, options) : get.call(this, kind, { ...options, willReadFrequently: true });
  };
  prototype.getContext = marking as typeof prototype.getContext;
}

/** The context that draws on `canvas`; the canvas is shown, and nothing reads its pixels through its element. */
export function penOf(canvas: HTMLCanvasElement): Pen | null {
  return showing(() => canvas.getContext("2d"));
}

/** Runs `make`, which makes canvases that will be shown on the page. */
export function showing<T>(make: () => T): T {
  shown = true;
  try {
    return make();
  } finally {
    shown = false;
  }
}

/** The context of the offscreen canvas behind `canvas`. Width and height of the element read and set those of the offscreen canvas. */
export function handedOver(canvas: HTMLCanvasElement, options: object = {}): Pen | null {
  const known = pens.get(canvas);
  if (known !== undefined) return known;
  const behind = canvas.transferControlToOffscreen();
  // The contexts of both kinds of canvas have the same drawing methods.
  const pen = behind.getContext("2d", { ...options, willReadFrequently: true }) as unknown as Pen | null;
  for (const side of ["width", "height"] as const) {
    Object.defineProperty(canvas, side, { get: () => behind[side], set: (pixels: number) => (behind[side] = pixels) });
  }
  if (pen !== null) pens.set(canvas, pen);
  return pen;
}
