// The page of a recorded flight: one script, one stylesheet and the page without them, which `twin export html` puts into one
// file with the flight.
import { defineConfig, type Plugin } from "vite";
import { replayPage } from "./src/replay/page";

/** Writes replay.html with the parts of index.html in their places. */
const page: Plugin = {
  name: "replay-page",
  async generateBundle() {
    const read = (file: string): Promise<string> => this.fs.readFile(file, { encoding: "utf8" });
    this.emitFile({ type: "asset", fileName: "replay.html", source: replayPage(await read("replay.html"), await read("index.html")) });
  },
};

export default defineConfig({
  define: { "process.env.NODE_ENV": '"production"' },
  plugins: [page],
  build: {
    target: "es2022",
    chunkSizeWarningLimit: 1000,
    lib: { entry: "src/replay/main.ts", formats: ["iife"], name: "twinReplay", fileName: () => "replay.js", cssFileName: "replay" },
  },
});
