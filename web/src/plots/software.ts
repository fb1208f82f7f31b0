// Without a graphics card every 2-D canvas that is not marked as read back goes through the software rasteriser and
// takes the page's frames: 6 frames/s against 42 with five charts.

/** Marks every 2-D context created from now on as read back. Call before the first chart. */
export function preferProcessorCanvas(): void {
  const prototype = HTMLCanvasElement.prototype;
  const original = prototype.getContext as (this: HTMLCanvasElement, kind: string, options?: object) => RenderingContext | null;
  const patched = function (this: HTMLCanvasElement, kind: string, options?: object): RenderingContext | null {
    return original.call(this, kind, kind === "2d" ? { ...options, willReadFrequently: true } : options);
  };
  prototype.getContext = patched as typeof prototype.getContext;
}
