import { createHash } from "node:crypto";
import { readdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { defineConfig } from "vite";

const PAGE = resolve(import.meta.dirname, "../python/hydrocrane/app/cockpit_page");
const SERVICE_WORKER = "service-worker.js";

/** Kept by a browser only once it was needed. */
const ON_DEMAND = /\/chains-/;

/** Gives the service worker the list of files to keep and a version that any change to any file changes. */
function offline() {
  return {
    name: "offline",
    writeBundle() {
      const source = readFileSync(resolve(import.meta.dirname, "src", SERVICE_WORKER));
      const all = readdirSync(PAGE, { recursive: true }).map((file) => file.replaceAll("\\", "/"));
      const files = all.filter((file) => statSync(join(PAGE, file)).isFile() && file !== SERVICE_WORKER).sort();
      const version = createHash("sha256").update(source);
      files.forEach((file) => version.update(file).update(readFileSync(join(PAGE, file))));
      const facts = {
        FILES: files.filter((file) => !ON_DEMAND.test(file)),
        LATER: files.filter((file) => ON_DEMAND.test(file)),
        VERSION: version.digest("hex").slice(0, 16),
      };
      const head = Object.entries(facts).map(([name, value]) => `const ${name} = ${JSON.stringify(value)};\n`);
      writeFileSync(join(PAGE, SERVICE_WORKER), head.join("") + source);
    },
  };
}

// Everything is found relative to the page, so that it works from any folder of any host.
export default defineConfig({
  base: "./",
  plugins: [offline()],
  build: {
    outDir: PAGE,
    emptyOutDir: true,
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    target: "es2022",
  },
  worker: { format: "es" },
});
