// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The page with a long dive, in a headless Chromium that draws in software: how soon it is complete, how long a picture
// takes while the scene turns against the same cloud drawn as so many points, what the browser holds as the dive goes on,
// and what is left in the device of pages that were killed.
// node tests/benchmark/page.mjs [late] [growing] [reopening] [served]
//
// The dive is a short simulated one that nadir maps, laid side by side until it has as many images.
import { spawn } from "node:child_process";
import { createHash } from "node:crypto";
import { readFileSync, readdirSync } from "node:fs";
import http from "node:http";
import net from "node:net";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { gunzipSync } from "node:zlib";
import * as harness from "../browser/harness.mjs";
import { pause, until } from "../browser/harness.mjs";

const ROOT = fileURLToPath(new URL("../../", import.meta.url));
const IMAGES = 580;
const SHORT = 40;
const HEADER = 16;
const VERSION = 2;
const TYPE = { welcome: 2, state: 3, camera: 5, pose: 6, planeGrid: 8, planeColour: 9, mosaic: 10, mosaicTile: 11, caughtUp: 14, mosaicOverview: 23 };
const PROMPT = [TYPE.pose, TYPE.planeGrid, TYPE.planeColour, TYPE.mosaicOverview];
const OF_MOSAICS = [TYPE.mosaicTile, TYPE.mosaicOverview];
const APART = 30; // survey units between the copies
const LATE_VIEWERS = 5;
const TURNS = 60; // pictures measured
const PLAIN_TURNS = 6; // they take seconds

/** All that the server behind a port sends a page of a dive that was mapped. */
async function recordsOf(browser, port) {
  const feed = [];
  const { page, read } = await harness.openPage(browser, port, (page) => {
    page.on("websocket", (socket) => {
      if (/\/feed/.test(socket.url())) socket.on("framereceived", ({ payload }) => feed.push(Buffer.from(payload)));
    });
  });
  await until("the dive mapped", read, ({ state, counts }) => state?.finished === true && counts.mosaicTiles >= state.mosaicTiles, 120);
  await page.close();
  const newest = new Map();
  for (const record of feed) newest.set(`${record[0]} ${keyOf(record)}`, record);
  return [...newest.values()];
}

function keyOf(record) {
  if (OF_MOSAICS.includes(record[0])) return record.subarray(HEADER, HEADER + 12).toString("hex");
  const keyed = [TYPE.pose, TYPE.planeGrid, TYPE.planeColour].includes(record[0]);
  return keyed ? record.readBigUInt64LE(HEADER) : 0;
}

/** The record of the k-th copy of the dive. */
function copy(record, k) {
  const bytes = Buffer.from(record);
  const shift = (at, by) => bytes.writeDoubleLE(bytes.readDoubleLE(at) + by, at);
  const type = record[0];
  if ([TYPE.pose, TYPE.planeGrid, TYPE.planeColour].includes(type)) {
    bytes.writeBigUInt64LE(bytes.readBigUInt64LE(HEADER) + BigInt(k * SHORT), HEADER);
  }
  const [dx, dy] = [APART * (k % 8), APART * Math.floor(k / 8)];
  if (type === TYPE.pose) {
    shift(HEADER + 16, dx);
    shift(HEADER + 24, dy);
  } else if (type === TYPE.planeGrid) {
    const matrix = HEADER + 16;
    for (let column = 0; column < 3; ++column) {
      const weight = bytes.readDoubleLE(matrix + 8 * (9 + column));
      shift(matrix + 8 * column, dx * weight);
      shift(matrix + 8 * (3 + column), dy * weight);
    }
    shift(matrix + 96, dx);
    shift(matrix + 104, dy);
  } else if (type === TYPE.mosaic) {
    bytes.writeUInt32LE(k, HEADER);
    shift(HEADER + 8 + 8 + 32, dx);
    shift(HEADER + 8 + 8 + 40, dy);
  } else if (OF_MOSAICS.includes(type)) {
    bytes.writeUInt32LE(k, HEADER);
  }
  return bytes;
}

function longDive(records, images) {
  const repeated = new Set([TYPE.pose, TYPE.planeGrid, TYPE.planeColour, TYPE.mosaic, ...OF_MOSAICS]);
  const all = records.filter((record) => record[0] === TYPE.camera || record[0] === TYPE.state);
  for (let k = 0; k * SHORT < images; ++k) {
    for (const record of records) if (repeated.has(record[0])) all.push(copy(record, k));
  }
  let sequence = 1n;
  for (const record of all) record.writeBigUInt64LE(sequence++, 8);
  return all.filter((record) => {
    const keyed = [TYPE.pose, TYPE.planeGrid, TYPE.planeColour].includes(record[0]);
    return !keyed || record.readBigUInt64LE(HEADER) < BigInt(images);
  });
}

/** In the order in which the server sends them to a late viewer: include/nadir/wire, Lanes. */
function asServed(records) {
  const prompt = records.filter(({ 0: type }) => PROMPT.includes(type));
  const data = records.filter(({ 0: type }) => type === TYPE.mosaicTile);
  const served = records.filter(({ 0: type }) => type !== TYPE.mosaicTile && !PROMPT.includes(type));
  const sent = { prompt: 0, data: 0 };
  while (prompt.length + data.length > 0) {
    const isPrompt = data.length === 0 || (prompt.length > 0 && sent.prompt <= 2 * sent.data);
    const record = (isPrompt ? prompt : data).pop();
    sent[isPrompt ? "prompt" : "data"] += record.length;
    served.push(record);
  }
  return served;
}

const imageOf = (record) => {
  if (![TYPE.pose, TYPE.planeGrid, TYPE.planeColour].includes(record[0])) return [TYPE.mosaic, ...OF_MOSAICS].includes(record[0]) ? record.readUInt32LE(HEADER) * SHORT : 0;
  return Number(record.readBigUInt64LE(HEADER));
};

/** A WebSocket message of a server. RFC 6455, 5.2. */
function framed(record) {
  const size = record.length;
  const header = Buffer.alloc(size < 126 ? 2 : size < 65536 ? 4 : 10);
  header.set([0x82, size < 126 ? size : size < 65536 ? 126 : 127]);
  if (header.length === 4) header.writeUInt16BE(size, 2);
  if (header.length === 10) header.writeBigUInt64BE(BigInt(size), 2);
  return Buffer.concat([header, record]);
}

/** Serves the page as the server does, fed with these records in place of its own, or by the server behind a port; others
 *  may answer what they know. */
async function frontWith(feed, answers = () => false) {
  const behind = Array.isArray(feed) ? port : feed;
  const sockets = [];
  const front = http.createServer((request, response) => {
    if (answers(request, response)) return;
    http.get({ host: "127.0.0.1", port: behind, path: request.url, headers: request.headers }, (answer) => {
      response.writeHead(answer.statusCode, answer.headers);
      answer.pipe(response);
    });
  });
  front.on("upgrade", (request, socket, head) => {
    if (!Array.isArray(feed)) return passOn(request, socket, head, behind);
    if (!request.url.startsWith("/feed")) return; // alerts come by the feed as well
    const key = createHash("sha1").update(`${request.headers["sec-websocket-key"]}258EAFA5-E914-47DA-95CA-C5AB0DC85B11`).digest("base64");
    socket.write(`HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${key}\r\n\r\n`);
    const welcome = Buffer.alloc(HEADER + 16);
    welcome.set([TYPE.welcome, VERSION]);
    welcome.writeBigUInt64LE(7n, HEADER);
    const caughtUp = Buffer.alloc(HEADER + 16);
    caughtUp.set([TYPE.caughtUp, VERSION]);
    for (const record of [welcome, ...feed, caughtUp]) socket.write(framed(record));
    socket.on("error", () => socket.destroy());
    sockets.push(socket);
  });
  await new Promise((resolve) => front.listen(0, "127.0.0.1", resolve));
  return { port: front.address().port, send: (record) => sockets.at(-1).write(framed(record)), close: () => front.close() };
}

/** A WebSocket to the server behind a port, byte by byte. */
function passOn(request, socket, head, port) {
  const far = net.connect(port, "127.0.0.1");
  const fields = Object.entries(request.headers).map(([name, value]) => `${name}: ${value}\r\n`);
  far.write(`GET ${request.url} HTTP/1.1\r\n${fields.join("")}\r\n`);
  far.write(head);
  far.pipe(socket).pipe(far);
  for (const end of [far, socket]) end.on("error", () => [far, socket].forEach((one) => one.destroy()));
}

async function openWith(browser, records) {
  const front = await frontWith(records);
  const opened = await harness.openPage(browser, front.port);
  return { ...opened, send: front.send, close: () => opened.page.close().then(front.close) };
}

/** Milliseconds from the page's first request until it has drawn so many planes and tiles, in a browser that nothing but
 *  the page keeps busy: a debugger is told all that comes over a socket once more, which takes as much as the page does. */
async function unwatched(feed, planes, tiles) {
  const probe = `const timer = setInterval(() => {
    const { counts, isDrawn } = window.nadir;
    if (counts.planes < ${planes} || counts.mosaicTiles < ${tiles} || !isDrawn) return;
    clearInterval(timer);
    fetch("drawn", { method: "POST" });
  }, 20);`;
  let begun, drawn;
  const isDrawn = new Promise((resolve) => (drawn = resolve));
  const front = await frontWith(feed, ({ url }, response) => {
    if (url === "/") begun ??= performance.now();
    if (url === "/drawn") drawn(performance.now());
    // The browser is at rest before it is asked for the page.
    if (url === "/warm") response.end("<script>setTimeout(() => (location = '/'), 3000)</script>");
    else if (url === "/probe.js") response.setHeader("Content-Type", "text/javascript").end(probe);
    else if (url === "/drawn") response.end();
    else if (url === "/") {
      http.get({ host: "127.0.0.1", port, path: "/", headers: { "Accept-Encoding": "gzip" } }, async (answer) => {
        const page = gunzipSync(Buffer.concat(await answer.toArray())).toString();
        const { "content-encoding": _, "content-length": __, ...headers } = answer.headers;
        response.writeHead(200, headers).end(page.replace("</body>", '<script type="module" src="probe.js"></script></body>'));
      });
    } else return false;
    return true;
  });
  const child = spawn(harness.CHROMIUM, [...harness.CHROMIUM_OPTIONS, "--headless=new", "--window-size=1280,800", `--user-data-dir=${harness.temporaryFolder()}`,
    `http://127.0.0.1:${front.port}/warm`], { stdio: "ignore", detached: true });
  const ended = new Promise((resolve) => child.on("exit", resolve));
  const at = await Promise.race([isDrawn, pause(60_000).then(() => Infinity)]);
  process.kill(-child.pid);
  await ended;
  front.close();
  return at - begun;
}

/** The same of a nadir that has mapped so many images and serves them itself. */
async function servedLate(folder, images) {
  const survey = path.join(folder, "long");
  harness.simulate(survey, "--scene", "pool", "--images", String(images), "--stereo", "--seed", "7");
  const port = await harness.freePort();
  const run = await harness.replay(survey, path.join(folder, "served"), port, "--keep-serving", "--rate", "max");
  const { page, read } = await harness.openPage(browser, port);
  const { state } = await until("the dive mapped", read, ({ state, counts }) => state?.finished === true && counts.planes >= state.planes, 1200);
  await page.close();
  const times = [];
  for (let i = 0; i < LATE_VIEWERS; ++i) times.push((await unwatched(port, state.planes, state.mosaicTiles)) / 1000);
  console.log(`${state.planes} planes and ${state.mosaicTiles} tiles of ${images} images, by nadir itself: ${times.map((time) => time.toFixed(2)).join(", ")} s`);
  say("all of it is drawn after", median(times), "s", 3);
  run.stop();
  await run.ended;
}

/** Median milliseconds from picture to picture while the scene turns under the mouse. */
async function turning(page) {
  const box = await page.evaluate(() => {
    const { left, top, width, height } = document.querySelector("canvas").getBoundingClientRect();
    return { x: left + width / 2, y: top + height / 2 };
  });
  await page.mouse.move(box.x, box.y);
  await page.mouse.down();
  const measured = page.evaluate(
    (count) =>
      new Promise((resolve) => {
        const times = [];
        const step = (now) => {
          times.push(now);
          dispatchTurn(times.length);
          if (times.length <= count) requestAnimationFrame(step);
          else resolve(times.slice(1).map((time, i) => time - times[i]));
        };
        const canvas = document.querySelector("canvas");
        const { left, top, width, height } = canvas.getBoundingClientRect();
        const dispatchTurn = (i) => {
          const at = { clientX: left + width / 2 + 3 * i, clientY: top + height / 2, pointerId: 1, bubbles: true, buttons: 1 };
          canvas.dispatchEvent(new PointerEvent("pointermove", { ...at, pointerType: "mouse" }));
        };
        requestAnimationFrame(step);
      }),
    TURNS,
  );
  const intervals = await measured;
  await page.mouse.up();
  return median(intervals);
}

async function heap(page) {
  const session = await page.context().newCDPSession(page);
  await session.send("HeapProfiler.collectGarbage");
  return (await session.send("Runtime.getHeapUsage")).usedSize;
}

const require = createRequire(path.join(ROOT, "web/package.json"));

/** The same cloud as so many points, each with a place and a colour, drawn by the same library. */
async function naive(browser, points) {
  const { build } = await import(require.resolve("vite").replace(/index\.cjs$/, "dist/node/index.js"));
  const built = await build({
    root: path.join(ROOT, "web"),
    logLevel: "error",
    configFile: false,
    resolve: { alias: { three: require.resolve("three").replace(/three\.cjs$/, "three.module.js") } },
    build: { write: false, lib: { entry: path.join(ROOT, "tests/benchmark/naive_points.js"), formats: ["es"], fileName: "naive" } },
  });
  const page = await browser.newPage({ viewport: { width: 1184, height: 704 } });
  await page.setContent('<!doctype html><canvas id="canvas" style="position:fixed;inset:0;width:100%;height:100%"></canvas>');
  await page.addScriptTag({ type: "module", content: built[0].output[0].code });
  await until("the naive cloud", () => page.evaluate(() => window.draw !== undefined), (ready) => ready, 60);
  const ms = await page.evaluate(([count, turns]) => window.draw(count, turns), [points, PLAIN_TURNS]);
  await page.close();
  return ms;
}

const median = (values) => [...values].sort((one, other) => one - other)[Math.floor(values.length / 2)];

/** MB of memory of a process and those it started; what they share is counted once. */
function memory(pid) {
  const processes = new Map();
  for (const name of readdirSync("/proc").filter((entry) => /^\d+$/.test(entry))) {
    try {
      const [status, rollup] = ["status", "smaps_rollup"].map((file) => readFileSync(`/proc/${name}/${file}`, "utf8"));
      const field = (text, key) => Number(new RegExp(`^${key}:\\s+(\\d+)`, "m").exec(text)?.[1] ?? 0);
      processes.set(Number(name), { parent: field(status, "PPid"), kilobytes: field(rollup, "Pss_Anon") + field(rollup, "Pss_Shmem") });
    } catch {
      // It has ended meanwhile.
    }
  }
  const isOf = (one) => one === pid || (processes.has(one) && isOf(processes.get(one).parent));
  return [...processes].filter(([one]) => isOf(one)).reduce((sum, [, { kilobytes }]) => sum + kilobytes, 0) / 1000;
}

/** Of the browser that the others belong to. */
async function pidOf(browser) {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send("SystemInfo.getProcessInfo");
  return processInfo.find(({ type }) => type === "browser").id;
}

const verdicts = [];
function say(what, value, unit, bar) {
  const met = bar === undefined || value <= bar;
  console.log(`${what}: ${value.toFixed(2)} ${unit}${bar === undefined ? "" : `, bar ${bar}: ${met ? "met" : "MISSED"}`}`);
  verdicts.push(met);
}

async function lateViewer(browser, records) {
  const dive = asServed(longDive(records, IMAGES));
  const planes = dive.filter((record) => record[0] === TYPE.planeColour).length;
  const ofPlanes = dive.filter((record) => record[0] === TYPE.planeColour || record[0] === TYPE.planeGrid);
  console.log(`${planes} planes, ${planes * 15000} points`);
  say("a plane", ofPlanes.reduce((sum, record) => sum + record.length, 0) / planes / 1000, "kB", 10);
  const tiles = dive.filter((record) => record[0] === TYPE.mosaicTile).length;
  console.log(`${tiles} tiles of mosaics`);
  const times = [];
  for (let i = 0; i < LATE_VIEWERS; ++i) times.push((await unwatched(dive, planes, tiles)) / 1000);
  console.log(`late viewers: ${times.map((time) => time.toFixed(2)).join(", ")} s`);
  say("all planes, coarsely, and the mosaics in sight of a late viewer are drawn after", median(times), "s", 3);
  const { page, read, close } = await openWith(browser, dive);
  await until("all planes", read, ({ counts }) => counts.planes >= planes, 120);
  await page.click("nav >> text=3D");
  const shown = performance.now();
  await until("planes cell by cell", () => page.evaluate(() => window.nadir.finePlanes), (count) => count >= Math.min(512, planes), 120);
  console.log(`cell by cell in 3D ${((performance.now() - shown) / 1000).toFixed(2)} s after a touch on it, with a debugger`);
  await pause(3000);
  const quads = await turning(page);
  await page.click("nav >> text=Layers");
  await page.click("role=switch[name='Planes as points']");
  await page.click("nav >> text=Layers");
  await pause(2000);
  const points = await turning(page);
  await close();
  const plain = await naive(browser, planes * 15000);
  console.log(`from picture to picture: ${quads.toFixed(0)} ms as quads, ${points.toFixed(0)} ms as points, ${plain.toFixed(0)} ms as plain points`);
  say("quads to plain points", quads / plain, "", 1 / 3);
  say("points to plain points", points / plain, "", 1 / 3);
}

/** What a browser that has a disk holds while a dive grows to so many images. */
async function growing(_, records, images) {
  const dive = longDive(records, images);
  const tablet = await harness.chromium({ profile: harness.temporaryFolder() });
  const { page, read, send, close } = await openWith(tablet, []);
  const tabletPid = await pidOf(tablet.browser());
  await until("a link", read, ({ link }) => link === "live");
  const part = images / 5;
  const held = [];
  for (let end = part; end <= images; end += part) {
    for (const record of dive) {
      const at = imageOf(record);
      if (at >= end - part && at < end) send(record);
    }
    const planes = dive.filter((record) => record[0] === TYPE.planeColour && imageOf(record) < end).length;
    await until("the planes", read, ({ counts }) => counts.planes >= planes, 300);
    await pause(3000);
    held.push([end, memory(tabletPid), (await heap(page)) / 1e6]);
    console.log(`${end} images: ${held.at(-1)[1].toFixed(0)} MB of the browser, ${held.at(-1)[2].toFixed(0)} MB of the tab's heap`);
  }
  await close();
  await tablet.close();
  // Until then the page keeps what it is told with itself.
  const [from, before] = held[1];
  say(`an image more after ${from}`, ((held.at(-1)[1] - before) * 1000) / (images - from), "kB", 30);
}

/** Pages killed one after the other while a dive is mapped, and what is left of them in the device. */
async function reopening(browser, survey, folder, times) {
  const port = await harness.freePort();
  const run = await harness.replay(survey, path.join(folder, "reopened"), port, "--rate", "1", "--keep-serving");
  const files = () => readdirSync(`/proc/${run.pid}/fd`).length;
  const took = [];
  let before = null;
  for (let i = 0; i < times; ++i) {
    const begun = performance.now();
    const { page, read } = await harness.openPage(browser, port);
    const isComplete = ({ counts, state }) => state !== null && state.planes > 0 && counts.planes >= state.planes && counts.mosaicTiles >= state.mosaicTiles;
    const { state } = await until("the view complete", read, isComplete, 120);
    took.push(performance.now() - begun);
    const session = await page.context().newCDPSession(page);
    session.send("Page.crash").catch(() => undefined);
    await page.waitForEvent("crash");
    await page.close();
    // From the end of the mapping on nothing but pages may take memory.
    if (state.finished && before === null) {
      await pause(2000);
      before = { after: i + 1, memory: memory(run.pid), files: files() };
    }
  }
  await pause(12_000); // what is silent is let go
  say(`memory of the device after ${times - before.after} more pages were killed`, memory(run.pid) - before.memory, "MB", 2);
  say("files it holds more", files() - before.files, "", 0);
  const [first, last] = [took.slice(before.after, before.after + 10), took.slice(-10)].map((some) => median(some) / 1000);
  console.log(`complete after ${first.toFixed(2)} s, at last ${last.toFixed(2)} s`);
  say("the last to the first", last / first, "", 1.3);
  run.stop();
  await run.ended;
}

const folder = harness.temporaryFolder();
const survey = path.join(folder, "survey");
harness.simulate(survey, "--scene", "pool", "--images", String(SHORT), "--stereo", "--seed", "7");
const browser = await harness.chromium();
const port = await harness.freePort();
const server = await harness.replay(survey, path.join(folder, "dive"), port, "--keep-serving");
const records = await recordsOf(browser, port);
const parts = { late: () => lateViewer(browser, records), growing: () => growing(browser, records, 5000), reopening: () => reopening(browser, survey, folder, 50), served: () => servedLate(folder, 520) };
for (const part of process.argv.length > 2 ? process.argv.slice(2) : Object.keys(parts)) await parts[part]();
server.stop();
await browser.close();
process.exit(verdicts.every(Boolean) ? 0 : 1);
