// Without a graphics card every 2-D canvas that is not marked as read back goes through the software rasteriser and takes
// the page's frames: 6 frames/s against 42 with five charts. And a canvas of the page itself is copied and composed anew
// with every frame of the page, drawn on or not; one whose control was handed over is when it was drawn on only.

type Pen = CanvasRenderingContext2D;
type GetContext = (this: HTMLCanvasElement, kind: string, options?: object) => RenderingContext | null;

const pens = new WeakMap<HTMLCanvasElement, Pen>();
let patched = false;
/** Canvases that ask for a context now are shown. */
let shown = false;

/** Marks every 2-D context created from now on as read back. Call before the first chart. */
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

/** What draws on `canvas`, which is shown and never read by its element. */
export function penOf(canvas: HTMLCanvasElement): Pen | null {
  return showing(() => canvas.getContext("2d"));
}

/** Runs `make`, which makes canvases that are shown. */
export function showing<T>(make: () => T): T {
  shown = true;
  try {
    return make();
  } finally {
    shown = false;
  }
}

/** Draws on the canvas that stands behind `canvas`; sizes set on the element are those of that one. */
export function handedOver(canvas: HTMLCanvasElement, options: object = {}): Pen | null {
  const known = pens.get(canvas);
  if (known !== undefined) return known;
  const behind = canvas.transferControlToOffscreen();
  // The two kinds of context draw alike.
  const pen = behind.getContext("2d", { ...options, willReadFrequently: true }) as unknown as Pen | null;
  for (const side of ["width", "height"] as const) {
    Object.defineProperty(canvas, side, { get: () => behind[side], set: (pixels: number) => (behind[side] = pixels) });
  }
  if (pen !== null) pens.set(canvas, pen);
  return pen;
}
