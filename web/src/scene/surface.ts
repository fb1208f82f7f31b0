// The surfaces on which pictures appear. With a graphics card the renderer draws into the page's canvas. Without one the browser would
// block the whole page until a picture is computed. The picture is therefore drawn into another canvas, read when it is ready, and
// copied into the page's canvas.
import { WebGLRenderer } from "three";
import { handedOver } from "../plots/software";

export interface Surface {
  renderer: WebGLRenderer;
  /** Shows a picture that is ready. Returns false while a picture is being computed; then no other picture may be drawn. */
  ready(): boolean;
  /** Ends a picture: it consists of all that was drawn since the last call. */
  finish(): void;
}

/** Whether WebGL works without a graphics card, so that every pixel costs processor time. */
export function isSoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (gl === null) return true;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = String(gl.getParameter(info === null ? gl.RENDERER : info.UNMASKED_RENDERER_WEBGL));
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /SwiftShader|llvmpipe|Software/i.test(name);
}

/** A surface that draws into `canvas` itself. */
export function directSurface(canvas: HTMLCanvasElement): Surface {
  const renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
  return { renderer, ready: () => true, finish: () => undefined };
}

/** A surface that draws into another canvas and copies into `canvas`, without ever waiting for a picture. */
export class SoftwareSurface implements Surface {
  readonly renderer: WebGLRenderer;
  private readonly gl: WebGL2RenderingContext;
  private readonly pen: CanvasRenderingContext2D;
  private buffer: WebGLBuffer | null = null;
  private fence: WebGLSync | null = null;
  private image = new ImageData(1, 1);
  private rows = new Uint8Array(4);

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas: new OffscreenCanvas(1, 1), antialias: false, alpha: false });
    this.gl = this.renderer.getContext() as WebGL2RenderingContext;
    const pen = handedOver(canvas, { alpha: false });
    if (pen === null) throw new Error("no 2-D canvas");
    this.pen = pen;
  }

  ready(): boolean {
    const { gl, fence } = this;
    if (fence === null) return true;
    if (gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) return false;
    gl.deleteSync(fence);
    this.fence = null;
    if (!gl.isContextLost()) this.show();
    return true;
  }

  finish(): void {
    const { gl } = this;
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    if (this.buffer === null || this.image.width !== width || this.image.height !== height) this.resize(width, height);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.buffer);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
  }

  private resize(width: number, height: number): void {
    const { gl } = this;
    this.image = new ImageData(width, height);
    this.rows = new Uint8Array(this.image.data.length);
    this.buffer ??= gl.createBuffer();
    // STREAM_COPY and not STREAM_READ: for READ Chromium makes a second copy and warns that nothing uses it.
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.buffer);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, this.rows.length, gl.STREAM_COPY);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
  }

  private show(): void {
    const { gl, image } = this;
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.buffer);
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, this.rows);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    turnOver(this.rows, image.data, image.width * 4);
    if (this.canvas.width !== image.width || this.canvas.height !== image.height) {
      this.canvas.width = image.width;
      this.canvas.height = image.height;
    }
    this.pen.putImageData(image, 0, 0);
  }
}

/** Copies lines of `stride` bytes in reverse order, because WebGL has the lowest line first and a canvas the uppermost. */
export function turnOver(from: Uint8Array, to: Uint8ClampedArray, stride: number): void {
  for (let low = 0, high = from.length - stride; high >= 0; low += stride, high -= stride) to.set(from.subarray(low, low + stride), high);
}
