// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { patchMeans, pause } from "./harness.mjs";

const PLACES = 20;
const GREY_LEVELS = 8;

/** The mosaic on the screen against its file (path without extension) at 20 places. */
export async function sampleMosaic(browser, page, mosaic) {
  const world = readFileSync(`${mosaic}.pgw`, "utf8").trim().split(/\s+/).map(Number);
  const png = readFileSync(`${mosaic}.png`);
  const width = png.readUInt32BE(16);
  const height = png.readUInt32BE(20);
  assert.ok(await page.evaluate(() => window.nadir.fitMosaic(0)));
  await page.click("nav >> text=Layers");
  for (const layer of ["Coverage and gaps", "Plan and lanes", "Cameras and path"]) {
    await page.click(`role=switch[name='${layer}']`);
  }
  await page.click("nav >> text=Layers");
  await pause(1000);
  const screen = await page.screenshot();

  // Every cell of a grid over the mosaic is a candidate; those wholly opaque and not behind a card count.
  const candidates = [];
  const across = 24;
  for (let i = 0; i < across * across; ++i) {
    const column = ((i % across) + 0.5) * (width / across);
    const row = (Math.floor(i / across) + 0.5) * (height / across);
    candidates.push({ column, row, x: world[0] * column + world[4], y: world[3] * row + world[5] });
  }
  const onScreen = await page.evaluate(
    (places) =>
      places.map(({ x, y }) => {
        const at = window.nadir.screenOf(x, y, 0);
        return at !== null && document.elementFromPoint(at.x, at.y)?.id === "canvas" ? at : null;
      }),
    candidates,
  );
  const half = 3; // screen px
  const perPixel = await page.evaluate(
    ([x, y, step]) => window.nadir.screenOf(x + step, y, 0).x - window.nadir.screenOf(x, y, 0).x,
    [world[4], world[5], world[0]],
  );
  const places = candidates.map((place, i) => ({ ...place, at: onScreen[i] })).filter(({ at }) => at !== null);
  // Screen pixel i covers [i, i + 1), file pixel i [i - 1/2, i + 1/2): both patches cover the same ground.
  const onDisk = await patchMeans(
    browser,
    png,
    places.map(({ column, row, at }) => ({
      x: column + 0.5 + (Math.round(at.x) - at.x) / perPixel,
      y: row + 0.5 + (Math.round(at.y) - at.y) / perPixel,
      half: half / perPixel,
    })),
  );
  const shown = await patchMeans(
    browser,
    screen,
    places.map(({ at }) => ({ x: Math.round(at.x), y: Math.round(at.y), half })),
  );
  const opaque = places.map((_, i) => i).filter((i) => onDisk[i][3] === 255);
  assert.ok(opaque.length >= PLACES, `only ${opaque.length} places to sample`);
  const chosen = Array.from({ length: PLACES }, (_, i) => opaque[Math.floor((i * opaque.length) / PLACES)]);
  const differences = chosen.map((i) => Math.max(...[0, 1, 2].map((k) => Math.abs(onDisk[i][k] - shown[i][k]))));
  if (process.env.NADIR_VERBOSE) console.log(differences.map((d) => d.toFixed(1)).join(" "));
  assert.ok(Math.max(...differences) <= GREY_LEVELS, `grey levels: ${differences.map((d) => d.toFixed(1))}`);
  const greys = chosen.map((i) => onDisk[i][0]);
  assert.ok(Math.max(...greys) - Math.min(...greys) > 20, "the places all look alike: nothing was tested");
}

/** One and two fingers, mouse wheel and keyboard. */
export async function useHands(page) {
  const session = await page.context().newCDPSession(page);
  const touch = (type, points) =>
    session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const drag = async (...fingers) => {
    await touch("touchStart", fingers.map(([from]) => from));
    for (let step = 1; step <= 8; ++step) {
      await touch("touchMove", fingers.map(([from, to]) => [0, 1].map((k) => from[k] + ((to[k] - from[k]) * step) / 8)));
    }
    await touch("touchEnd", []);
    await pause(300);
  };
  const corners = () =>
    page.evaluate(() => [
      window.nadir.screenOf(0, 0, 0),
      window.nadir.screenOf(1, 0, 0),
      window.nadir.screenOf(0, 0, 1),
    ]);
  const changed = async (act) => {
    const before = await corners();
    await act();
    const after = await corners();
    const shift = (i) => [after[i].x - before[i].x, after[i].y - before[i].y];
    const length = ([a, b]) => Math.hypot(b.x - a.x, b.y - a.y);
    return { shift: shift(0), turned: Math.hypot(shift(1)[0] - shift(0)[0], shift(1)[1] - shift(0)[1]), zoom: length(after) / length(before) };
  };

  await page.click("nav >> text=3D");
  await pause(500);
  const orbit = await changed(() => drag([[640, 300], [760, 360]]));
  assert.ok(orbit.turned > 1, `one finger turns the scene: ${JSON.stringify(orbit)}`);
  const pinch = await changed(() => drag([[600, 350], [500, 350]], [[700, 350], [800, 350]]));
  assert.ok(pinch.zoom > 1.5, `two fingers zoom: ${JSON.stringify(pinch)}`);

  await page.click("nav >> text=Map");
  await pause(500);
  const pan = await changed(() => drag([[600, 300], [700, 350]]));
  assert.ok(Math.abs(pan.shift[0] - 100) < 15 && Math.abs(pan.shift[1] - 50) < 15, `the map follows the finger: ${pan.shift}`);
  assert.ok(pan.turned < 0.01, "the map does not turn");
  const wheel = await changed(async () => {
    await page.mouse.move(640, 350);
    await page.mouse.wheel(0, -400);
    await pause(300);
  });
  assert.ok(wheel.zoom > 1.1, `the wheel zooms: ${wheel.zoom}`);
  const keys = await changed(async () => {
    await page.focus("#canvas");
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("+");
    await pause(300);
  });
  assert.ok(keys.zoom > 1.2, `plus zooms: ${keys.zoom}`);
  await page.click("#zoom >> text=All");
}
