// The socket lives in a worker. A busy page therefore delays drawing, but it loses no frame and its data do not count as stale.
import { backoffMs } from "./health";

export type ToWorker = { kind: "open"; url: string } | { kind: "send"; text: string };
export type FromWorker =
  | { kind: "open"; at: number }
  | { kind: "closed"; at: number; retryMs: number }
  | { kind: "text"; at: number; text: string }
  | { kind: "binary"; at: number; frame: ArrayBuffer };

interface WorkerScope {
  postMessage(message: FromWorker, transfer?: Transferable[]): void;
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
}

const scope = self as unknown as WorkerScope;
const PING_EVERY_MS = 1000;
/** A connection without a message for this long counts as dead, even if TCP has not noticed it, ms. */
const DEAD_AFTER_MS = 5000;
let socket: WebSocket | null = null;
let failures = 0;
let heardAt = 0;

/** Time on the page's clock, ms (a worker's own clock starts later). */
const now = (): number => performance.timeOrigin + performance.now();

function connect(url: string): void {
  const current = new WebSocket(url);
  current.binaryType = "arraybuffer";
  socket = current;
  heardAt = now();
  let ended = false;
  const end = (): void => {
    if (ended) return;
    ended = true;
    clearInterval(watch);
    const retryMs = backoffMs(failures);
    failures += 1;
    scope.postMessage({ kind: "closed", at: now(), retryMs });
    setTimeout(() => connect(url), retryMs);
  };
  const watch = setInterval(() => {
    if (now() - heardAt > DEAD_AFTER_MS) {
      current.close();
      end();
    } else if (current.readyState === WebSocket.OPEN) {
      current.send(JSON.stringify({ type: "ping", t: now() }));
    }
  }, PING_EVERY_MS);
  current.onopen = () => scope.postMessage({ kind: "open", at: now() });
  current.onclose = end;
  current.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) => {
    if (ended) return;
    heardAt = now();
    failures = 0;
    if (typeof data === "string") scope.postMessage({ kind: "text", at: heardAt, text: data });
    else scope.postMessage({ kind: "binary", at: heardAt, frame: data }, [data]);
  };
}

scope.onmessage = ({ data }) => {
  if (data.kind === "open") connect(data.url);
  else if (socket?.readyState === WebSocket.OPEN) socket.send(data.text);
};
