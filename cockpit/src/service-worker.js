// The page without a network: keeps the files of one build, whose list and version the build writes before this text.
/* global FILES, LATER, VERSION */

const SCOPE = self.registration.scope;
const PREFIX = `hydrocrane ${SCOPE} `;
const CACHE = PREFIX + VERSION;
/** Stands in the page of every build. */
const MARK = 'name="application-name" content="hydrocrane cockpit"';
const address = (file) => new URL(file, SCOPE).href;
const OWN = new Set([...FILES, ...LATER].map(address));
const PAGES = new Set(["", "index.html"].map(address));

self.addEventListener("install", (event) => {
  const fresh = FILES.map((file) => new Request(file, { cache: "reload" }));
  event.waitUntil(caches.open(CACHE).then((cache) => cache.addAll(fresh)).then(() => self.skipWaiting()));
});

async function forget(keep) {
  const old = (await caches.keys()).filter((name) => name.startsWith(PREFIX) && name !== keep);
  await Promise.all(old.map((name) => caches.delete(name)));
}

self.addEventListener("activate", (event) => event.waitUntil(forget(CACHE).then(() => self.clients.claim())));

self.addEventListener("fetch", (event) => {
  const { request } = event;
  if (request.method !== "GET") return;
  const bare = request.url.split(/[?#]/)[0];
  // The network has the newest page; files below it carry their version in their name. Anything else is none of ours.
  if (request.mode === "navigate") event.respondWith(newest(request, PAGES.has(bare)));
  else if (bare.includes("/assets/") && OWN.has(bare)) event.respondWith(kept(request));
});

async function newest(request, page) {
  let answer;
  try {
    answer = await fetch(request);
  } catch (error) {
    const found = page && (await caches.match("index.html", { cacheName: CACHE }));
    if (found) return found;
    throw error;
  }
  if (page && !(await isOurs(answer.clone()))) {
    // Another program has this address now.
    await forget();
    await self.registration.unregister();
  }
  return answer;
}

/** A host that is out of order for a while is no other program. */
async function isOurs(answer) {
  if (answer.status >= 500) return true;
  return answer.ok && (await answer.text()).includes(MARK);
}

async function kept(request) {
  const found = await caches.match(request, { cacheName: CACHE });
  if (found) return found;
  const answer = await fetch(request);
  // Where the cache was forgotten, it stays so.
  if (answer.ok && (await caches.has(CACHE))) await (await caches.open(CACHE)).put(request, answer.clone());
  return answer;
}
