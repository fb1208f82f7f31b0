// The page's end of the connection: typed messages in and out, and what is known about the connection's health.
import type { ClientMessage, ServerMessage } from "../protocol";
import { decodeTelemetry, type Telemetry } from "./decode";
import { LinkHealth } from "./health";
import type { FromWorker, ToWorker } from "./socket.worker";

export interface LinkHandlers {
  message(message: ServerMessage): void;
  telemetry(telemetry: Telemetry): void;
  /** Something that came cannot be read; shown to the operator. */
  unreadable(text: string): void;
  connection(connected: boolean, retryMs: number): void;
}

/** The newest frame of telemetry on its way: when it left by the server's clock, came and was taken in by the page's, ms. */
export interface Delivery {
  tick: number;
  leftMs: number;
  cameMs: number;
  takenMs: number;
}

/** Now on the clock shared with the worker, ms. */
export const clockMs = (): number => performance.timeOrigin + performance.now();

export class Link {
  readonly health = new LinkHealth();
  delivery: Delivery | null = null;
  private readonly worker = new Worker(new URL("./socket.worker.ts", import.meta.url), { type: "module" });

  constructor(private readonly handlers: LinkHandlers) {
    this.worker.onmessage = ({ data }: MessageEvent<FromWorker>) => this.receive(data);
  }

  open(url: string): void {
    this.post({ kind: "open", url });
  }

  /** Sends `message`; without a connection it is lost, and the operator sees that there is none. */
  send(message: ClientMessage): void {
    this.post({ kind: "send", text: JSON.stringify(message) });
  }

  private post(message: ToWorker): void {
    this.worker.postMessage(message);
  }

  private receive(data: FromWorker): void {
    switch (data.kind) {
      case "open":
        this.health.open(data.at);
        this.handlers.connection(true, 0);
        return;
      case "closed":
        this.health.connected = false;
        this.handlers.connection(false, data.retryMs);
        return;
      case "text":
        this.health.message(data.at);
        this.health.bytes(data.at, data.text.length);
        this.text(data.text, data.at);
        return;
      case "binary":
        this.binary(data.frame, data.at);
    }
  }

  private text(text: string, at: number): void {
    let message: ServerMessage;
    try {
      message = JSON.parse(text) as ServerMessage;
    } catch {
      this.handlers.unreadable(`the server sent text that is not JSON: ${text.slice(0, 60)}`);
      return;
    }
    if (message.type === "pong") this.health.roundTripMs = at - message.t;
    this.handlers.message(message);
  }

  private binary(frame: ArrayBuffer, at: number): void {
    this.health.bytes(at, frame.byteLength);
    try {
      const telemetry = decodeTelemetry(frame);
      this.health.telemetry(at, telemetry.gap);
      this.handlers.telemetry(telemetry);
      this.delivery = { tick: telemetry.firstTick + telemetry.rows - 1, leftMs: telemetry.tWall * 1e3, cameMs: at, takenMs: clockMs() };
    } catch (error) {
      this.handlers.unreadable(error instanceof Error ? error.message : String(error));
    }
  }
}
