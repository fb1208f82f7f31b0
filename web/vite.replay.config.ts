// The page of a recorded flight: one script and one stylesheet, which `twin export html` puts into one file with the flight.
import { defineConfig } from "vite";

export default defineConfig({
  define: { "process.env.NODE_ENV": '"production"' },
  build: {
    target: "es2022",
    chunkSizeWarningLimit: 1000,
    lib: { entry: "src/replay/main.ts", formats: ["iife"], name: "twinReplay", fileName: () => "replay.js", cssFileName: "replay" },
  },
});
