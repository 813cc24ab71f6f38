// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Keeps the page, not its data, so that it opens while the device is still starting. Browsers allow it on localhost
// and over a trusted certificate only.

interface Lasting extends Event {
  waitUntil(work: Promise<unknown>): void;
}
interface Fetching extends Event {
  request: Request;
  respondWith(answer: Promise<Response>): void;
}

const CACHE = "nadir";
const PAGE = ["./", "page.js", "unpacker.js", "page.css", "icon.svg", "manifest.webmanifest"];
/** A device that is there answers sooner. */
const PATIENCE_MS = 3000;

addEventListener("install", (event) => {
  (event as Lasting).waitUntil(caches.open(CACHE).then((cache) => cache.addAll(PAGE)));
});

addEventListener("fetch", (event) => {
  const { request } = event as Fetching;
  const { pathname } = new URL(request.url);
  if (request.method !== "GET" || pathname.includes("/api/")) return;
  (event as Fetching).respondWith(freshOrKept(request));
});

/** The device's own, which is also kept, so that a page never speaks another protocol than its device; else what was kept. */
async function freshOrKept(request: Request): Promise<Response> {
  const cache = await caches.open(CACHE);
  try {
    const fresh = await fetch(request, { signal: AbortSignal.timeout(PATIENCE_MS) });
    if (fresh.ok) await cache.put(request, fresh.clone());
    return fresh;
  } catch (fault) {
    const kept = await cache.match(request, { ignoreSearch: true });
    if (kept === undefined) throw fault;
    return kept;
  }
}
