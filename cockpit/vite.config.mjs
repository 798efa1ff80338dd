import { defineConfig } from "vite";

// Everything is found relative to the page, so that it works from any folder of any host.
export default defineConfig({
  base: "./",
  build: {
    outDir: "../python/hydrocrane/app/cockpit_page",
    emptyOutDir: true,
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    target: "es2022",
  },
  worker: { format: "es" },
});
