// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What is drawn, looked at and touched.
import assert from "node:assert/strict";
import { pause, until } from "./harness.mjs";

/** Fingers that go from one place to another, all at once. */
export async function drag(page, ...tracks) {
  const session = await page.context().newCDPSession(page);
  const touch = (type, points) =>
    session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  await touch("touchStart", tracks.map(([from]) => from));
  for (let step = 1; step <= 8; ++step) {
    await touch("touchMove", tracks.map(([from, to]) => [0, 1].map((k) => from[k] + ((to[k] - from[k]) * step) / 8)));
  }
  await touch("touchEnd", []);
  await session.detach();
  await pause(200);
}

/** A picture at rest is drawn anew, in full, within so many ms: view/budget.ts. */
const REST_MS = 350;

/** What the canvas looks like, left of an open sheet, once it does not change any more. */
export async function still(page) {
  const clip = await page.evaluate(() => {
    const { x, y, right, height } = document.getElementById("canvas").getBoundingClientRect();
    const panel = document.getElementById("panel");
    return { x, y, width: (panel.hidden ? right : panel.getBoundingClientRect().left) - x, height };
  });
  await until("drawn", () => page.evaluate(() => window.nadir.isDrawn), Boolean, 20);
  await pause(REST_MS);
  let last = await page.screenshot({ clip });
  for (let i = 0; i < 20; ++i) {
    await pause(REST_MS);
    const now = await page.screenshot({ clip });
    if (now.equals(last)) return now;
    last = now;
  }
  throw new Error("the canvas comes to no rest");
}

/** Pixels of a PNG: {width, height, data}. */
export async function pixelsOf(judge, png) {
  const { width, height, base64 } = await judge.evaluate(async (given) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${given}`)).blob(), { colorSpaceConversion: "none" });
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    let text = "";
    for (let i = 0; i < data.length; i += 8192) text += String.fromCharCode(...data.subarray(i, i + 8192));
    return { width: bitmap.width, height: bitmap.height, base64: btoa(text) };
  }, png.toString("base64"));
  return { width, height, data: new Uint8ClampedArray(Buffer.from(base64, "base64")) };
}

/** How many pixels two pictures of the same size do not share. */
export async function difference(judge, one, other) {
  if (one.equals(other)) return 0;
  const [a, b] = (await Promise.all([pixelsOf(judge, one), pixelsOf(judge, other)])).map(({ data }) => data);
  let count = 0;
  for (let i = 0; i < a.length; i += 4) if ([0, 1, 2].some((k) => Math.abs(a[i + k] - b[i + k]) > 12)) ++count;
  return count;
}

export async function isAgain(page, judge, before) {
  const now = await still(page);
  const count = await difference(judge, before, now);
  assert.ok(count < 100, `${count} px are not as they were`);
}
