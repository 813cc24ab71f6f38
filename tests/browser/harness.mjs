// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A nadir that replays a simulated dive, a connection to it that can be cut, and a headless Chromium.
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import net from "node:net";
import { tmpdir } from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";

const ROOT = fileURLToPath(new URL("../../", import.meta.url));
export const PROGRAM = process.env.NADIR_PROGRAM ?? path.join(ROOT, "build/release/nadir");
export const CHROMIUM = process.env.NADIR_CHROMIUM ?? "/usr/bin/chromium";

export const missing = [PROGRAM, CHROMIUM].filter((file) => !existsSync(file));

export function temporaryFolder() {
  const folder = mkdtempSync(path.join(tmpdir(), "nadir-browser-"));
  process.on("exit", () => rmSync(folder, { recursive: true, force: true }));
  return folder;
}

export function simulate(folder, ...options) {
  const { status, stderr } = spawnSync(PROGRAM, ["simulate", "--out", folder, ...options], { encoding: "utf8" });
  if (status !== 0) throw new Error(`nadir simulate failed: ${stderr}`);
}

export async function replay(folder, dive, port, ...options) {
  const serve = options.includes("--serve") ? [] : ["--serve", `127.0.0.1:${port}`];
  return serving(["replay", folder, "--out", dive, ...serve, ...options]);
}

/** Resolves when the server listens; `ended` resolves with the exit status. */
export async function serving(words, environment = {}) {
  const child = spawn(PROGRAM, words, { env: { ...process.env, ...environment } });
  let said = "";
  child.stderr.on("data", (text) => (said += text));
  const ended = new Promise((resolve) => child.on("exit", resolve));
  process.on("exit", () => child.kill());
  while (!said.includes("http://")) {
    if (child.exitCode !== null) throw new Error(`nadir ${words[0]} ended: ${said}`);
    await pause(50);
  }
  return { ended, stop: () => child.kill("SIGTERM"), said: () => said, pid: child.pid };
}

export const diveJson = (dive) => JSON.parse(readFileSync(path.join(dive, "dive.json"), "utf8"));

export async function freePort() {
  const server = net.createServer().listen(0, "127.0.0.1");
  await new Promise((resolve) => server.on("listening", resolve));
  const { port } = server.address();
  await new Promise((resolve) => server.close(resolve));
  return port;
}

/** A port that leads to another one, until cut. */
export async function lineTo(port) {
  const sockets = new Set();
  let isCut = false;
  const server = net.createServer((near) => {
    if (isCut) return near.destroy();
    const far = net.connect(port, "127.0.0.1");
    for (const [one, other] of [
      [near, far],
      [far, near],
    ]) {
      sockets.add(one);
      one.pipe(other);
      one.on("error", () => other.destroy());
      one.on("close", () => {
        sockets.delete(one);
        other.destroy();
      });
    }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return {
    port: server.address().port,
    cut: () => {
      isCut = true;
      sockets.forEach((socket) => socket.destroy());
    },
    mend: () => (isCut = false),
    close: () => {
      sockets.forEach((socket) => socket.destroy());
      server.close();
    },
  };
}

/** The device's name to other computers; here it is this one. */
export const DEVICE = "nadir.local";

/** Draws in software and asks nothing of anybody. */
export const CHROMIUM_OPTIONS = [
  "--no-sandbox",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-background-networking",
  "--disable-quic",
  "--no-first-run",
  "--disable-sync",
  "--disable-component-update",
];

/** profile: a folder in which it keeps what it does not hold in memory. */
export async function chromium({ program = CHROMIUM, profile = null, more = [] } = {}) {
  const { chromium } = createRequire(path.join(ROOT, "web/package.json"))("playwright-core");
  const options = { executablePath: program, args: [...CHROMIUM_OPTIONS, `--host-resolver-rules=MAP ${DEVICE} 127.0.0.1`, ...more] };
  return profile === null ? chromium.launch(options) : chromium.launchPersistentContext(profile, options);
}

/** A 10-inch tablet, held either way. */
export const LANDSCAPE = { width: 1280, height: 800 };
export const PORTRAIT = { width: 800, height: 1280 };

/** The page of the server behind a port, with what it asked for and complained of. */
export async function openPage(browser, port, prepare = async () => undefined, viewport = LANDSCAPE, address = `http://127.0.0.1:${port}/`) {
  const page = await browser.newPage({ viewport, hasTouch: true });
  const requests = [];
  const errors = [];
  page.on("request", (request) => requests.push(request.url()));
  page.on("websocket", (socket) => requests.push(socket.url()));
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (message) => {
    if (message.type() === "error") errors.push(message.text());
  });
  await prepare(page);
  await page.goto(address);
  const read = () =>
    page.evaluate(() => ({
      counts: window.nadir.counts,
      state: window.nadir.state,
      link: window.nadir.link,
      ignored: window.nadir.ignored,
    }));
  return { page, requests, errors, read };
}

/** Mean colours of square patches of a PNG, decoded by a page of its own: [{x, y, half}] to [[r, g, b, least alpha]]. */
export async function patchMeans(browser, png, patches) {
  const page = await browser.newPage();
  const means = await page.evaluate(
    async ({ base64, patches }) => {
      const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
      const bitmap = await createImageBitmap(new Blob([bytes]), {
        colorSpaceConversion: "none",
        premultiplyAlpha: "none",
      });
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
      context.drawImage(bitmap, 0, 0);
      return patches.map(({ x, y, half }) => {
        const left = Math.round(x - half);
        const top = Math.round(y - half);
        const side = Math.max(1, Math.round(2 * half));
        if (left < 0 || top < 0 || left + side > bitmap.width || top + side > bitmap.height) return [0, 0, 0, 0];
        const { data } = context.getImageData(left, top, side, side);
        const sum = [0, 0, 0];
        let alpha = 255;
        for (let i = 0; i < data.length; i += 4) {
          for (let k = 0; k < 3; ++k) sum[k] += data[i + k];
          alpha = Math.min(alpha, data[i + 3]);
        }
        return [...sum.map((value) => value / (side * side)), alpha];
      });
    },
    { base64: png.toString("base64"), patches },
  );
  await page.close();
  return means;
}

/** Where pictures of the page are kept to be looked at. */
const pictures = process.env.NADIR_PICTURES;
if (pictures) mkdirSync(pictures, { recursive: true });
export const keep = async (page, name) => {
  if (pictures) await page.screenshot({ path: path.join(pictures, `${name}.png`) });
};

export const tap = async (page, selector) => {
  const target = page.locator(selector).first();
  await target.waitFor();
  await target.tap();
};

export const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** Polls until the condition holds; throws with the last value when it does not in time. */
export async function until(what, read, condition, seconds = 60) {
  const deadline = Date.now() + 1000 * seconds;
  for (;;) {
    const value = await read();
    if (condition(value)) return value;
    if (Date.now() > deadline) throw new Error(`${what}: not within ${seconds} s, last ${JSON.stringify(value)}`);
    await pause(100);
  }
}
