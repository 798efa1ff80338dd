/** Keeps the page for times without a network. */

/** Whether a program on this computer serves the page, which another program can follow at the same address. */
export const servedLive = (): boolean => document.documentElement.dataset["served"] === "live";

export function keepOffline(): void {
  if (!("serviceWorker" in navigator)) return;
  if (servedLive()) return void forget().catch(() => undefined);
  // The names of a build's files carry its version: under another address a newer worker takes over at once, where a browser
  // would take its time to look for changes. Without a network, or where a browser keeps nothing, one still drives.
  const files = document.querySelectorAll<HTMLElement>("script[src], link[rel=stylesheet]");
  const version = [...files].map((file) => (file.getAttribute("src") ?? file.getAttribute("href"))?.split("/").at(-1)).join();
  navigator.serviceWorker.register(`./service-worker.js?${version}`).catch(() => undefined);
}

/** Whoever kept this page at this address before keeps it no longer. */
async function forget(): Promise<void> {
  for (const kept of await navigator.serviceWorker.getRegistrations()) {
    if (!kept.active?.scriptURL.includes("/service-worker.js")) continue;
    const old = (await caches.keys()).filter((name) => name.startsWith(`hydrocrane ${kept.scope} `));
    await Promise.all(old.map((name) => caches.delete(name)));
    await kept.unregister();
  }
}
