// A second client that shares no code with the page. It decodes the server's messages byte by byte, as the protocol's text says.
import WebSocket from "ws";

export class Oracle {
  hello = null;
  lastTick = -1;
  /** World pose of each body at the newest tick, by name. */
  poses = new Map();
  /** Value of each channel at the newest tick, by name. */
  channels = new Map();
  resets = 0;
  gapTicks = 0;
  /** Simulated time and wall time of the newest frame on the server's clocks, s. */
  simulatedS = NaN;
  wallS = NaN;

  static async connect(url) {
    const oracle = new Oracle();
    oracle.socket = new WebSocket(url.replace("http", "ws") + "/ws");
    oracle.socket.on("message", (data, binary) => (binary ? oracle.#telemetry(data) : oracle.#text(JSON.parse(data))));
    await new Promise((resolve, reject) => {
      oracle.socket.once("open", resolve);
      oracle.socket.once("error", reject);
    });
    return oracle;
  }

  close() {
    this.socket.terminate();
  }

  #text(message) {
    if (message.type === "hello") this.hello = message;
    if (message.type === "reset") {
      this.lastTick = -1;
      this.resets = 0;
    }
  }

  #telemetry(data) {
    if (this.hello === null || data.readUInt16LE(2) !== this.hello.schema_id) return;
    const [rows, channels, bodies] = [8, 10, 12].map((offset) => data.readUInt16LE(offset));
    if ((data.readUInt32LE(20) & 1) === 1) this.resets = 0;
    this.gapTicks += data.readUInt32LE(16);
    const reset = this.hello.channels.findIndex(({ name }) => name === "reset");
    for (let row = 0; row < rows; row += 1) {
      if (data.readFloatLE(44 + 4 * (row * channels + reset)) === 1) this.resets += 1;
    }
    this.hello.channels.forEach(({ name }, k) => this.channels.set(name, data.readFloatLE(44 + 4 * ((rows - 1) * channels + k))));
    const moving = this.hello.scene.bodies.filter((body) => body.moving);
    const start = 44 + 4 * rows * channels;
    for (let body = 0; body < bodies; body += 1) {
      const pose = Array.from({ length: 7 }, (_, k) => data.readFloatLE(start + 4 * (7 * body + k)));
      this.poses.set(moving[body].name, pose);
    }
    this.lastTick = data.readUInt32LE(4) + rows - 1;
    this.simulatedS = data.readDoubleLE(24);
    this.wallS = data.readDoubleLE(32);
  }
}
