/** Keeps the page for times without a network. */

export function keepOffline(): void {
  // `hydrocrane live` lays out another drive at the same address each time: nothing of it is to be kept.
  if (new URLSearchParams(location.search).has("chosen") || !("serviceWorker" in navigator)) return;
  // The names of a build's files carry its version: under another address a newer worker takes over at once, where a browser
  // would take its time to look for changes. Without a network, or where a browser keeps nothing, one still drives.
  const files = document.querySelectorAll<HTMLElement>("script[src], link[rel=stylesheet]");
  const version = [...files].map((file) => (file.getAttribute("src") ?? file.getAttribute("href"))?.split("/").at(-1)).join();
  navigator.serviceWorker.register(`./service-worker.js?${version}`).catch(() => undefined);
}
