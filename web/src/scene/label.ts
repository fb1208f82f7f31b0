// A label in the 3-D view with the same size at every distance.
import { CanvasTexture, Sprite, SpriteMaterial } from "three";
import { FIELD_OF_VIEW_DEG } from "./camera";
import { MARKS_LAYER } from "./layers";

const FONT_PX = 28;
const PAD_PX = 8;
/** Height of a label in the picture, CSS px. */
const HEIGHT_PX = 17;

export class Label {
  readonly sprite: Sprite;
  private readonly canvas = document.createElement("canvas");
  private pictureHeight = 600;
  private readonly texture = new CanvasTexture(this.canvas);

  constructor(
    private readonly text: string,
    color: string,
    ground: string,
  ) {
    this.sprite = new Sprite(new SpriteMaterial({ map: this.texture, sizeAttenuation: false, depthTest: false, transparent: true }));
    this.sprite.center.set(0, 1.15);
    this.sprite.renderOrder = 3;
    this.sprite.layers.set(MARKS_LAYER);
    this.recolor(color, ground);
  }

  recolor(color: string, ground: string): void {
    const pen = this.canvas.getContext("2d");
    if (pen === null) return;
    const font = `600 ${FONT_PX}px system-ui, "DejaVu Sans", sans-serif`;
    pen.font = font;
    this.canvas.width = Math.ceil(pen.measureText(this.text).width) + 2 * PAD_PX;
    this.canvas.height = FONT_PX + 2 * PAD_PX;
    pen.globalAlpha = 0.75;
    pen.fillStyle = ground;
    pen.fillRect(0, 0, this.canvas.width, this.canvas.height);
    pen.globalAlpha = 1;
    pen.font = font;
    pen.fillStyle = color;
    pen.textBaseline = "middle";
    pen.fillText(this.text, PAD_PX, this.canvas.height / 2 + 1);
    this.scale();
    this.texture.dispose();
    this.texture.needsUpdate = true;
  }

  /** Takes the height of the picture, CSS px. */
  resize(height: number): void {
    this.pictureHeight = height;
    this.scale();
  }

  private scale(): void {
    // Without attenuation a sprite has the size that it would have one metre from the camera.
    const metres = (HEIGHT_PX / this.pictureHeight) * 2 * Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360);
    this.sprite.scale.set((metres * this.canvas.width) / this.canvas.height, metres, 1);
  }

  dispose(): void {
    this.texture.dispose();
    this.sprite.material.dispose();
  }
}
