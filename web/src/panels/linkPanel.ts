// The panel with the health of the connection in numbers, below the age in the top bar.
import type { LinkHealth } from "../link/health";
import { byId, element } from "./dom";
import { hang, isOpen } from "./popover";

export interface LinkReadings {
  health: LinkHealth;
  now: number;
  flying: boolean;
  clients: number | undefined;
  pageFps: number;
}

export class LinkPanel {
  private readonly panel = byId("link-panel");
  private readonly rows = byId("link-rows");
  private newest: LinkReadings | null = null;

  constructor() {
    hang(this.panel, byId("link"), () => this.fill());
  }

  show(readings: LinkReadings): void {
    this.newest = readings;
    if (isOpen(this.panel)) this.fill();
  }

  private fill(): void {
    if (this.newest === null) return;
    this.rows.replaceChildren(
      ...rowsOf(this.newest).map(([name, value, help]) => element("tr", { title: help }, [element("th", { scope: "row", textContent: name }), element("td", { textContent: value })])),
    );
  }
}

/** Name, value and meaning of each line. */
export function rowsOf({ health, now, flying, clients, pageFps }: LinkReadings): [string, string, string][] {
  const age = health.ageMs(now, flying);
  const rate = health.bytesPerSecond(now);
  return [
    ["connection", health.connected ? "open" : "closed", "State of the socket to the server"],
    ["age of the data", Number.isFinite(age) ? `${age.toFixed(0)} ms` : "–", "Time since the newest telemetry arrived; while no flight runs, since the newest message"],
    ["round trip", Number.isFinite(health.roundTripMs) ? `${health.roundTripMs.toFixed(1)} ms` : "–", "Time from a ping to its answer, measured once a second"],
    ["telemetry", `${health.framesPerSecond(now)} frames/s`, "Frames received in the last second; a frame may have several ticks"],
    ["data", rate < 1000 ? `${rate.toFixed(0)} B/s` : `${(rate / 1000).toFixed(1)} kB/s`, "Bytes received in the last second"],
    ["lost ticks", `${health.gapTicks} in ${health.gapCount} gaps`, "Ticks that the server dropped because this page was too slow, since the connection opened"],
    ["3-D view", `${pageFps.toFixed(0)} pictures/s`, "How often this page drew the 3-D view in the last second; it draws only what has changed"],
    ["clients", clients === undefined || !health.connected ? "–" : String(clients), "Pages and programs connected to the server"],
    ["reconnects", String(health.reconnects), "Times this page had to connect again"],
  ];
}
