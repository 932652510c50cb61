import react from "@vitejs/plugin-react";
import { defineConfig } from "vitest/config";

/** The first that know CSS `light-dark()`: it must not be rewritten, Mantine sets the scheme at run time. */
const cssTarget = ["chrome123", "firefox120", "safari17.5"];
/** `npm run dev` beside a running server: where that server listens. */
const server = "http://127.0.0.1:8321";

export default defineConfig({
  base: "/",
  plugins: [react()],
  build: {
    outDir: "../server/static",
    emptyOutDir: true,
    target: "es2022",
    cssTarget,
    chunkSizeWarningLimit: 900,
  },
  server: {
    proxy: {
      "/api": server,
      "/ws": { target: server, ws: true },
      "/viser": { target: server, ws: true },
      "/rerun": server,
    },
  },
  // A busy machine is no defect: no test is timed.
  test: { environment: "node", include: ["src/**/*.test.ts"], testTimeout: 200_000 },
});
