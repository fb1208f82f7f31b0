/// <reference types="vitest/config" />
import { defineConfig, loadEnv } from "vite";

export default defineConfig(({ mode }) => {
  // Under `npm run dev` the page comes from vite and its data from a running twin: TWIN_URL says which.
  const twin = loadEnv(mode, ".", "TWIN_")["TWIN_URL"] ?? "http://127.0.0.1:8080";
  return {
    base: "./",
    build: { target: "es2022", chunkSizeWarningLimit: 1000 },
    worker: { format: "es" },
    // The test of the contrasts reads a stylesheet.
    test: { css: true },
    server: { proxy: { "/ws": { target: twin.replace(/^http/, "ws"), ws: true }, "/api": twin } },
  };
});
