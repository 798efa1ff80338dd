/** Keeps the page for times without a network. */

export function keepOffline(): void {
  // `hydrocrane live` lays out another drive at the same address each time: nothing of it is to be kept.
  if (new URLSearchParams(location.search).has("chosen") || !("serviceWorker" in navigator)) return;
  // A browser that keeps nothing, as in private windows, still drives.
  navigator.serviceWorker.register("./service-worker.js").catch(() => undefined);
}
