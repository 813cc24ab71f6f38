// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The page in a real browser against a real replay: node --test tests/browser
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import test from "node:test";
import { sampleMosaic, useHands } from "./checks.mjs";
import * as harness from "./harness.mjs";
import { pause, until } from "./harness.mjs";

const IMAGES = 40;
const RATE = 4;

const folder = harness.temporaryFolder();
const survey = path.join(folder, "survey");
const dive = path.join(folder, "dive");
assert.deepEqual(harness.missing, [], "not there");

const asInDiveJson = ({ counts }) => ({
  cameras: counts.oriented,
  tiePoints: counts.tie_points,
  planes: counts.planes,
  mosaicTiles: counts.mosaic_tiles,
});

test("the page", { timeout: 600_000 }, async (t) => {
  harness.simulate(survey, "--scene", "pool", "--images", String(IMAGES), "--stereo", "--seed", "7");
  const port = await harness.freePort();
  const line = await harness.lineTo(port);
  const browser = await harness.chromium();
  t.after(async () => {
    line.close();
    await browser.close();
  });

  const run = await harness.replay(survey, dive, port, "--rate", String(RATE), "--keep-serving");
  const { page, requests, errors, read } = await harness.openPage(browser, line.port);
  const seen = [];

  await t.test("shows a growing map while the dive is replayed", async () => {
    await until("finished", read, (now) => {
      seen.push(now);
      return now.state?.finished === true;
    }, 180);
    for (const name of ["cameras", "tiePoints", "planes", "mosaicTiles"]) {
      const counts = seen.map((now) => now.counts[name]);
      assert.ok(counts.every((count, i) => i === 0 || count >= counts[i - 1]), `${name} shrank: ${counts}`);
      assert.ok(new Set(counts).size >= 4, `${name} did not grow step by step: ${counts}`);
    }
    assert.ok(seen.some(({ state }) => state !== null && !state.finished && state.total === IMAGES));
  });

  await t.test("ends with the counts of dive.json", async () => {
    const wanted = asInDiveJson(harness.diveJson(dive));
    await holds(read, wanted);
    // A busy machine drops images at a given rate; some must be left to show.
    assert.ok(wanted.cameras >= IMAGES / 4, `only ${wanted.cameras} images oriented`);
    assert.deepEqual((await read()).ignored, 0);
  });

  await t.test("asks nothing of anybody but this server and has no error to report", () => {
    const own = new Set([`http://127.0.0.1:${line.port}`, `ws://127.0.0.1:${line.port}`]);
    assert.ok(requests.length >= 4, `only ${requests}`);
    assert.deepEqual(requests.filter((url) => !own.has(new URL(url).origin)), []);
    assert.deepEqual(errors, []);
  });

  await t.test("shows the mosaic in the colours of the mosaic file", async () => {
    await sampleMosaic(browser, page, path.join(dive, "mosaic2d", "mosaic-000"));
  });

  await t.test("turns, zooms and pans under fingers, mouse and keys", async () => {
    await useHands(page);
  });

  await t.test("comes back by itself after the connection was cut, with everything still there", async () => {
    const before = (await read()).counts;
    line.cut();
    await until("lost", read, (now) => now.link === "lost", 10);
    assert.deepEqual((await read()).counts, before);
    line.mend();
    await until("live", read, (now) => now.link === "live", 15);
    await pause(1000);
    assert.deepEqual((await read()).counts, before);
  });

  await t.test("gives a late viewer the whole dive", async () => {
    const late = await harness.openPage(browser, port);
    const wanted = (await read()).counts;
    await holds(late.read, wanted);
    assert.deepEqual(late.errors, []);
    await late.page.close();
  });

  await t.test("starts anew when the server does", async () => {
    run.stop();
    await run.ended;
    const again = await harness.replay(survey, path.join(folder, "again"), port, "--rate", "20", "--keep-serving");
    await until("another dive", read, (now) => now.link === "live" && now.state?.finished === false, 30);
    const wanted = () => asInDiveJson(harness.diveJson(path.join(folder, "again")));
    await until("finished", read, (now) => now.state?.finished === true, 120);
    await holds(read, wanted());
    again.stop();
    await again.ended;
  });
});

test("the page between garbage", { timeout: 300_000 }, async (t) => {
  const port = await harness.freePort();
  const browser = await harness.chromium();
  t.after(() => browser.close());
  const run = await harness.replay(survey, path.join(folder, "garbage"), port, "--rate", "20", "--keep-serving");
  let sent = 0;
  const { errors, read } = await harness.openPage(browser, port, (page) =>
    page.routeWebSocket(/feed/, (socket) => {
      socket.connectToServer().onMessage((message) => {
        socket.send(message);
        for (const garbage of mutations(Buffer.from(message), sent++)) socket.send(garbage);
      });
    }),
  );

  await t.test("counts it, stays alive and shows the dive", async () => {
    await until("finished", read, (now) => now.state?.finished === true, 120);
    const wanted = harness.diveJson(path.join(folder, "garbage")).counts;
    // Pictures take their time to be decoded.
    const isWhole = ({ counts }) => counts.cameras >= wanted.oriented && counts.mosaicTiles >= wanted.mosaic_tiles;
    const { ignored } = await until("the whole dive", read, isWhole, 30);
    assert.ok(ignored > 100, `only ${ignored} ignored`);
    assert.deepEqual(errors, []);
  });
  run.stop();
  await run.ended;
});

test("the page of a live dive", { timeout: 300_000 }, async (t) => {
  const port = await harness.freePort();
  const browser = await harness.chromium();
  t.after(() => browser.close());
  const run = await harness.replay(survey, path.join(folder, "live"), port, "--rate", "20", "--keep-serving");
  const check = readFileSync(new URL("../wire/golden/check.bin", import.meta.url));
  const { page, errors } = await harness.openPage(browser, port, (page) =>
    page.routeWebSocket(/feed/, (socket) => {
      socket.connectToServer().onMessage((message) => {
        socket.send(message);
        socket.send(check);
      });
    }),
  );

  await t.test("shows how the equipment does, the worst first, and how much is wrong", async () => {
    await page.waitForSelector("nav .tool:has-text('Menu') .bubble:has-text('1')");
    await page.click("nav >> text=Menu");
    await page.click("#panel >> text=System");
    const cards = await page.$$eval("#panel .alert", (all) => all.map((card) => [card.dataset.level, card.innerText.split(/\n+/)]));
    assert.deepEqual(cards, [
      ["bad", ["disk: /dives cannot be written: read-only", "check the disk"]],
      ["good", ["camera: 10.0 images a second"]],
    ]);
    assert.deepEqual(errors, []);
  });
  run.stop();
  await run.ended;
});

test("the page of a device with wrong settings", { timeout: 120_000 }, async (t) => {
  const port = await harness.freePort();
  const browser = await harness.chromium();
  t.after(() => browser.close());
  const config = path.join(folder, "nadir.toml");
  writeFileSync(config, "[odometry]\nwidnow = 5\n");
  // Under a service manager it waits for better ones.
  const run = await harness.serving(["run", "--config", config, "--serve", `127.0.0.1:${port}`], { NOTIFY_SOCKET: "@nadir-browser-test" });
  const { page, errors } = await harness.openPage(browser, port);

  await t.test("says so across the screen, however late it is opened", async () => {
    await page.waitForSelector("#alerts .alert[data-level=bad]:has-text('widnow')");
    await page.waitForSelector("nav .tool:has-text('Alerts') .bubble:has-text('1')");
    assert.deepEqual(errors.filter((error) => !/404/.test(error)), [], "but for the calls that are not answered yet");
  });
  run.stop();
  await run.ended;
});

// The lasers' scale becomes better along the way, and all that was placed by the first is placed again.
test("the page of a dive that was corrected", { timeout: 300_000 }, async (t) => {
  const lit = path.join(folder, "lit");
  const corrected = path.join(folder, "corrected");
  harness.simulate(lit, "--scene", "transect", "--images", "30");
  const port = await harness.freePort();
  const browser = await harness.chromium();
  t.after(() => browser.close());
  const run = await harness.replay(lit, corrected, port, "--keep-serving");
  const { page, errors, read } = await harness.openPage(browser, port);

  await t.test("shows every camera where trajectory.tum has it", async () => {
    await until("finished", read, (now) => now.state?.finished === true, 120);
    const wanted = places(path.join(corrected, "trajectory.tum"));
    const live = places(path.join(corrected, "trajectory_live.tum"));
    await until("its cameras", read, (now) => now.counts.cameras === wanted.length, 30);
    const shown = await page.evaluate((count) => [...Array(count).keys()].map(window.nadir.placeOf), wanted.length);
    const worst = (those) => Math.max(...those.map((place, i) => Math.hypot(...place.map((x, k) => x - wanted[i][k]))));
    assert.ok(worst(live) > 1e-3, `nothing was corrected: ${worst(live)}`);
    assert.ok(worst(shown) < 1e-4, `off by ${worst(shown)}`);
    assert.deepEqual(errors, []);
  });
  run.stop();
  await run.ended;
});

/** Positions of a trajectory of which every image is oriented. */
function places(file) {
  const lines = readFileSync(file, "utf8").split("\n");
  return lines.filter((line) => line !== "" && !line.startsWith("#")).map((line) => line.split(" ").slice(1, 4).map(Number));
}

/** The page soon has exactly these counts. */
async function holds(read, wanted) {
  const same = (now) => JSON.stringify(now.counts) === JSON.stringify(wanted);
  await until("counts", read, same, 20).catch(() => undefined);
  assert.deepEqual((await read()).counts, wanted);
}

/** A cut, a prolonged, a random and a textual message; all of them malformed. */
function mutations(message, seed) {
  const random = Buffer.from(Array.from({ length: 64 }, (_, i) => (seed * 31 + i * 17) & 255));
  random[1] = 0;
  return [message.subarray(0, seed % Math.min(message.length, 40)), Buffer.concat([message, random]), random, "garbage"];
}
