// The page's end of the connection: typed messages in both directions, and the health of the connection.
import type { ClientMessage, ServerMessage } from "../protocol";
import { decodeTelemetry, type Telemetry } from "./decode";
import { LinkHealth } from "./health";
import type { FromWorker, ToWorker } from "./socket.worker";

export interface LinkHandlers {
  message(message: ServerMessage): void;
  telemetry(telemetry: Telemetry): void;
  /** Takes a text for the operator that tells why a message of the server cannot be read. */
  unreadable(text: string): void;
  connection(connected: boolean, retryMs: number): void;
}

/** Times of the newest telemetry frame, ms: sent (server's clock), received and added to the store (page's clock). */
export interface Delivery {
  tick: number;
  leftMs: number;
  cameMs: number;
  takenMs: number;
}

/** Current time on the clock that the page shares with the worker, ms. */
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

  /** Sends `message`. Without a connection the message is lost, and a banner shows the operator that there is no connection. */
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
