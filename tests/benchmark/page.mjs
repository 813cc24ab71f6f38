// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The page with a long dive, in a headless Chromium that draws in software: how soon it is complete, how long a picture
// takes while the scene turns against the same cloud drawn as so many points, and what the tab holds.
// node tests/benchmark/page.mjs [IMAGES] (580)
//
// The dive is a short simulated one that nadir maps, laid side by side until it has as many images.
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";
import * as harness from "../browser/harness.mjs";
import { pause, until } from "../browser/harness.mjs";

const ROOT = fileURLToPath(new URL("../../", import.meta.url));
const IMAGES = Number(process.argv[2] ?? 580);
const SHORT = 40;
const HEADER = 16;
const TYPE = { welcome: 2, state: 3, camera: 5, pose: 6, planeGrid: 8, planeColour: 9, mosaic: 10, mosaicTile: 11, caughtUp: 14 };
const APART = 30; // survey units between the copies
const TURNS = 60; // pictures measured

/** All that the server behind a port sends a page of a dive that was mapped. */
async function recordsOf(browser, port) {
  const feed = [];
  const { page, read } = await harness.openPage(browser, port, (page) => {
    page.on("websocket", (socket) => socket.on("framereceived", ({ payload }) => feed.push(Buffer.from(payload))));
  });
  await until("the dive mapped", read, ({ state, counts }) => state?.finished === true && counts.mosaicTiles >= state.mosaicTiles, 120);
  await page.close();
  const newest = new Map();
  for (const record of feed) newest.set(`${record[0]} ${keyOf(record)}`, record);
  return [...newest.values()];
}

function keyOf(record) {
  if (record[0] === TYPE.mosaicTile) return record.subarray(HEADER, HEADER + 12).toString("hex");
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
  } else if (type === TYPE.mosaicTile) {
    bytes.writeUInt32LE(k, HEADER);
  }
  return bytes;
}

function longDive(records, images) {
  const repeated = new Set([TYPE.pose, TYPE.planeGrid, TYPE.planeColour, TYPE.mosaic, TYPE.mosaicTile]);
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

/** The page as the server of `port` gives it, fed with these records in place of its own. */
async function openWith(browser, port, records) {
  return harness.openPage(browser, port, (page) =>
    page.routeWebSocket(/feed/, (socket) => {
      socket.onMessage(() => {
        const welcome = Buffer.alloc(HEADER + 16);
        welcome[0] = TYPE.welcome;
        welcome[1] = 2;
        welcome.writeBigUInt64LE(7n, HEADER);
        socket.send(welcome);
        for (const record of records) socket.send(record);
      });
    }),
  );
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
  return intervals.sort((one, other) => one - other)[Math.floor(intervals.length / 2)];
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
    build: { write: false, lib: { entry: path.join(ROOT, "tests/benchmark/naive_points.js"), formats: ["es"], fileName: "naive" } },
  });
  const page = await browser.newPage({ viewport: { width: 1184, height: 704 } });
  await page.setContent('<!doctype html><canvas id="canvas" style="position:fixed;inset:0;width:100%;height:100%"></canvas>');
  await page.addScriptTag({ type: "module", content: built[0].output[0].code });
  await until("the naive cloud", () => page.evaluate(() => window.draw !== undefined), (ready) => ready, 60);
  const ms = await page.evaluate(([count, turns]) => window.draw(count, turns), [points, TURNS]);
  await page.close();
  return ms;
}

const folder = harness.temporaryFolder();
const survey = path.join(folder, "survey");
harness.simulate(survey, "--scene", "pool", "--images", String(SHORT), "--stereo", "--seed", "7");
const browser = await harness.chromium();
const port = await harness.freePort();
const server = await harness.replay(survey, path.join(folder, "dive"), port, "--keep-serving");
const records = await recordsOf(browser, port);

const dive = longDive(records, IMAGES);
const colours = dive.filter((record) => record[0] === TYPE.planeColour || record[0] === TYPE.planeGrid);
const planes = dive.filter((record) => record[0] === TYPE.planeColour).length;
console.log(`${planes} planes, ${planes * 15000} points, ${(colours.reduce((sum, record) => sum + record.length, 0) / planes / 1000).toFixed(1)} kB a plane`);

const begun = performance.now();
const { page, read } = await openWith(browser, port, dive);
await until("all planes", read, ({ counts }) => counts.planes >= planes, 120);
console.log(`complete after ${((performance.now() - begun) / 1000).toFixed(2)} s from nothing`);
await page.click("nav >> text=3D");
await pause(3000);
const quads = await turning(page);
await page.click("nav >> text=Layers");
await page.click("role=switch[name='Planes as points']");
await page.click("nav >> text=Layers");
await pause(2000);
const points = await turning(page);
console.log(`heap of the tab ${((await heap(page)) / 1e6).toFixed(0)} MB`);
await page.close();
const plain = await naive(browser, planes * 15000);
console.log(`from picture to picture: ${quads.toFixed(0)} ms as quads, ${points.toFixed(0)} ms as points, ${plain.toFixed(0)} ms as plain points`);
console.log(`ratio: ${(quads / plain).toFixed(3)} and ${(points / plain).toFixed(3)}`);
server.stop();
await browser.close();
