// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The page as a hand in a glove uses it, on a tablet held either way: node --test tests/browser
import assert from "node:assert/strict";
import { cpSync, existsSync, readFileSync, rmSync, readdirSync, writeFileSync } from "node:fs";
import path from "node:path";
import test from "node:test";
import { barriers, tooSmall } from "./fitness.mjs";
import * as harness from "./harness.mjs";
import { keep, pause, tap, until } from "./harness.mjs";
import { ALERT } from "./wire_records.mjs";

const SEED = "7";

const folder = harness.temporaryFolder();
const survey = path.join(folder, "survey");
assert.deepEqual(harness.missing, [], "not there");
harness.simulate(survey, "--scene", "pool", "--images", "40", "--stereo", "--seed", SEED);

const tapGround = async (page, [x, y, z]) => {
  const at = await page.evaluate(([x, y, z]) => window.nadir.screenOf(x, y, z), [x, y, z]);
  await page.touchscreen.tap(at.x, at.y);
};
const hint = (page) => page.locator("#hint .text").innerText();

for (const [held, viewport] of [
  ["landscape", harness.LANDSCAPE],
  ["portrait", harness.PORTRAIT],
]) {
  test(`a mapped dive on a tablet held in ${held}`, { timeout: 600_000 }, async (t) => {
    const port = await harness.freePort();
    const browser = await harness.chromium();
    t.after(() => browser.close());
    const dive = path.join(folder, held);
    const run = await harness.replay(survey, dive, port, "--keep-serving");
    const { page, errors, read } = await harness.openPage(browser, port, undefined, viewport);
    await until("finished", read, (now) => now.state?.finished === true, 180);
    await until("its tiles", read, ({ counts, state }) => counts.mosaicTiles === state.mosaicTiles, 60);
    const trajectory = readFileSync(path.join(dive, "trajectory.tum"), "utf8").split("\n").filter((line) => /^[0-9]/.test(line));
    const position = (image) => trajectory[image].split(" ").slice(1, 4).map(Number);

    await t.test("has nothing that a glove cannot hit or an eye cannot read, on any of its sheets", async () => {
      for (const stage of ["Map", "3D", "Image"]) {
        await tap(page, `nav >> text=${stage}`);
        assert.deepEqual(await tooSmall(page), [], stage);
        await keep(page, `${held}-${stage}`);
      }
      await tap(page, "nav >> text=Map");
      for (const sheet of ["Tools", "Layers", "Alerts", "Menu"]) {
        await tap(page, `nav >> text=${sheet}`);
        assert.deepEqual(await tooSmall(page), [], sheet);
        await keep(page, `${held}-${sheet}`);
      }
      for (const item of ["Dive", "Dives", "Code for a tablet", "System", "Display"]) {
        await tap(page, `#panel .wide:has(.label:text-is('${item}'))`);
        await page.waitForSelector("#panel [aria-label=Back]");
        assert.deepEqual(await tooSmall(page), [], item);
        assert.deepEqual(await barriers(page), [], item);
        await keep(page, `${held}-${item}`);
        await tap(page, "#panel [aria-label=Back]");
      }
      await tap(page, "#panel [aria-label=Close]");
    });

    await t.test("puts up no barrier, in any theme", async () => {
      assert.deepEqual(await barriers(page), []);
      for (const theme of ["Sunlight", "Night (red)", "Dark"]) {
        await tap(page, "nav >> text=Menu");
        await tap(page, "#panel >> text=Display");
        await tap(page, `#panel .wide:has-text('${theme}')`);
        await keep(page, `${held}-${theme}`);
        assert.deepEqual(await barriers(page), [], theme);
        await tap(page, "#panel [aria-label=Close]");
      }
    });

    await t.test("remembers the theme", async () => {
      await tap(page, "nav >> text=Menu");
      await tap(page, "#panel >> text=Display");
      await tap(page, "#panel .wide:has-text('Night')");
      await page.reload();
      assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "night");
      await tap(page, "nav >> text=Menu");
      await tap(page, "#panel >> text=Display");
      await tap(page, "#panel .wide:has-text('Dark')");
      await tap(page, "#panel [aria-label=Close]");
      await until("its tiles again", read, ({ counts, state }) => state !== null && counts.mosaicTiles === state.mosaicTiles, 60);
    });

    await t.test("says whether it tracks, how high, how fast and with what overlap", async () => {
      const gauge = (name) => page.locator(`.gauge.${name} .value`).innerText();
      assert.equal(await gauge("tracking"), "Mapped");
      const height = parseFloat(await gauge("altitude"));
      assert.ok(height > 0.5 && height < 5, `height ${height}`);
      assert.match(await gauge("overlap"), /^\d+ %$/);
      assert.match(await gauge("heading"), /^\d{3}°$/);
    });

    await t.test("says what part is covered and shows it on the map", async () => {
      assert.match(await page.locator("#guide .covered").innerText(), /^\d+ % of [\d.]+ m²$/);
      await tap(page, "nav >> text=Layers");
      const coverage = page.locator("role=switch[name='Coverage and gaps']");
      const before = await page.locator("#canvas").screenshot();
      await coverage.tap();
      assert.equal(await coverage.getAttribute("aria-checked"), "false");
      await pause(500);
      assert.notDeepEqual(await page.locator("#canvas").screenshot(), before);
      await coverage.tap();
      await tap(page, "nav >> text=Layers");
    });

    await t.test("measures with a ruler, and how sure that is", async () => {
      const [from, to] = [position(8), position(20)].map(([x, y]) => [x, y, 0]);
      await tap(page, "nav >> text=Tools");
      await tap(page, "#panel >> text=Ruler");
      await tapGround(page, from);
      await tapGround(page, to);
      const [, length, sigma] = /^([\d.]+) m ± ([\d.]+ \w+)$/.exec(await hint(page)) ?? [];
      const truth = Math.hypot(to[0] - from[0], to[1] - from[1]);
      const pixel = await page.evaluate(() => 1 / (window.nadir.screenOf(1, 0, 0).x - window.nadir.screenOf(0, 0, 0).x));
      assert.ok(Math.abs(length - truth) < 3 * pixel + 0.01, `${length} for ${truth}`);
      assert.ok(parseFloat(sigma) > 0, sigma);
      await keep(page, `${held}-ruler`);
      await tap(page, "#hint >> text=Done");
    });

    await t.test("says which image shows a place, when, from how far and how finely", async () => {
      const [x, y, z] = position(15);
      await tap(page, "nav >> text=Tools");
      await tap(page, "#panel >> text=What is here?");
      await tapGround(page, [x, y, 0]);
      const said = await hint(page);
      const [, image, distance] = /^Image (\d+) at .+, ([\d.]+) m away, [\d.]+ mm a pixel, seen by \d+ images$/.exec(said) ?? [];
      assert.ok(Math.abs(image - 15) <= 3, said);
      assert.ok(Math.abs(distance - z) < 0.35 * z, said);
      await tap(page, "#hint >> text=Done");
    });

    await t.test("looks straight down in 3D at a tap, and turns under a finger", async () => {
      await tap(page, "nav >> text=3D");
      await tap(page, "#zoom >> text=Top");
      const [below, above] = await page.evaluate(() => [window.nadir.screenOf(0, 0, 0), window.nadir.screenOf(0, 0, 1)]);
      const centre = { x: viewport.width / 2, y: viewport.height / 2 };
      const outward = Math.hypot(above.x - below.x, above.y - below.y) / Math.hypot(below.x - centre.x, below.y - centre.y);
      assert.ok(outward < 0.5, `what is above stands out by ${outward}`);
      await tap(page, "nav >> text=Map");
    });

    await t.test("zooms no further than there is something to be seen", async () => {
      const zoom = async (label) => {
        for (let i = 0; i < 60; ++i) await page.locator(`#zoom >> text=${label}`).evaluate((one) => one.click());
        const [one, other] = await page.evaluate(() => [window.nadir.screenOf(0, 0, 0), window.nadir.screenOf(0.01, 0, 0)]);
        return Math.hypot(one.x - other.x, one.y - other.y);
      };
      assert.ok((await zoom("Farther")) > 1e-3, "a centimetre is nothing");
      await keep(page, `farthest-${held}`);
      await tap(page, "#zoom >> text=All");
      const closest = await zoom("Closer");
      await keep(page, `closest-${held}`);
      assert.ok(closest > 100 && closest < 2000, `a centimetre is ${closest} px`);
      await tap(page, "#zoom >> text=All");
    });

    await t.test("takes a picture of the map", async () => {
      await tap(page, "nav >> text=Tools");
      const [download] = await Promise.all([page.waitForEvent("download"), tap(page, "#panel >> text=Screenshot")]);
      assert.match(download.suggestedFilename(), /^nadir-.+\.png$/);
      const png = readFileSync(await download.path());
      assert.equal(png.readUInt32BE(12), 0x49484452);
      assert.ok(png.length > 20_000, `${png.length} bytes`);
    });

    await t.test("shows the image with its tie points", async () => {
      await tap(page, "#live .frame");
      const count = Number(/(\d+) tie points/.exec(await page.locator("#picture .title").innerText())?.[1]);
      assert.ok(count > 50, `${count} tie points`);
      const lit = () => page.evaluate(() => {
        const canvas = document.querySelector("#picture .overlay");
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return data.filter((_, i) => i % 4 === 3).reduce((sum, alpha) => sum + (alpha > 0 ? 1 : 0), 0);
      });
      assert.ok((await lit()) > count, "they are marked");
      await tap(page, "nav >> text=Layers");
      await tap(page, "role=switch[name='Tie points']");
      assert.equal(await lit(), 0);
      await tap(page, "role=switch[name='Tie points']");
      await tap(page, "nav >> text=Layers");
      await tap(page, "nav >> text=Map");
    });

    await t.test("had no error to report", () => assert.deepEqual(errors, []));
    run.stop();
    await run.ended;
  });
}

const withoutAlerts = (page) =>
  page.routeWebSocket(/feed/, (socket) => {
    socket.connectToServer().onMessage((message) => {
      if (message[0] !== ALERT) socket.send(message);
    });
  });

// A dive of which a stretch is missing: tracking is lost where it begins.
test("a diver who is lost", { timeout: 300_000 }, async (t) => {
  const torn = path.join(folder, "torn");
  cpSync(survey, torn, { recursive: true });
  for (const side of ["left", "right"]) {
    const images = path.join(torn, "images", side);
    readdirSync(images).sort().forEach((name, i) => {
      if (i >= 16 && i < 30) rmSync(path.join(images, name));
    });
  }
  const port = await harness.freePort();
  const browser = await harness.chromium();
  t.after(() => browser.close());
  const run = await harness.replay(torn, path.join(folder, "lost"), port, "--rate", "1", "--keep-serving");
  const { page, errors, read } = await harness.openPage(browser, port);
  // Its feed holds up alerts, as one does that waits for a lost packet: they come by their own line.
  const upright = await harness.openPage(browser, port, withoutAlerts, harness.PORTRAIT);

  await t.test("is cried to across the screen and sees the last good view over the live image", async () => {
    // All at one moment: a loss may be over soon.
    const isCried = () => {
      const alert = document.querySelector("#alerts .alert[data-level=bad]");
      const ghost = document.querySelector("#picture.lost .ghost");
      const isWide = alert !== null && alert.getBoundingClientRect().width > 0.9 * document.querySelector("main").clientWidth;
      const isSeen = ghost !== null && ghost.checkVisibility() && ghost.getBoundingClientRect().width > 600;
      return isWide && isSeen && /^Swim (back the way|[\d.]+ m ± )/.test(document.querySelector("#picture .way").innerText);
    };
    await Promise.all(
      [page, upright.page].map(async (held, i) => {
        await held.waitForFunction(isCried, null, { polling: 50, timeout: 120_000 });
        await keep(held, i === 0 ? "lost" : "lost-portrait");
      }),
    );
    assert.deepEqual([...(await tooSmall(page)), ...(await tooSmall(upright.page))], []);
  });

  await t.test("folds the alert away once it is over, into the list", async () => {
    await until("found again", read, ({ state }) => state?.tracking === "tracking" || state?.finished, 60);
    await page.waitForSelector("#alerts .alert[data-level=bad]", { state: "detached", timeout: 30_000 });
    await tap(page, "nav >> text=Alerts");
    assert.match(await page.locator("#panel").innerText(), /does not overlap the images before/);
  });
  assert.deepEqual(errors, []);
  run.stop();
  await run.ended;
});

// Two dives of the same ground: one that is over, and the one that the device shows.
test("a recorded dive", { timeout: 600_000 }, async (t) => {
  const dives = path.join(folder, "dives");
  const earlier = path.join(dives, "earlier");
  const before = await harness.replay(survey, earlier, await harness.freePort());
  assert.equal(await before.ended, 0);
  const damaged = path.join(dives, "damaged");
  cpSync(earlier, damaged, { recursive: true });
  damage(path.join(damaged, "journal-000.nadir"));

  const port = await harness.freePort();
  const browser = await harness.chromium();
  t.after(() => browser.close());
  const run = await harness.replay(survey, path.join(dives, "now"), port, "--keep-serving");
  const { page, errors, read } = await harness.openPage(browser, port);
  const { token } = await (await fetch(`http://127.0.0.1:${port}/api/token`)).json();
  await page.goto(`http://127.0.0.1:${port}/#token=${token}`);
  await page.reload();
  const item = (label) => `#panel .wide:has(.label:text-is('${label}'))`;
  const openDive = async (name) => {
    await tap(page, "nav >> text=Menu");
    await tap(page, item("Dives"));
    await tap(page, item(name));
  };
  const banner = () => page.locator(".recorded").innerText();
  const isShown = (input) => ({ counts, state }) =>
    state?.input === input && state.finished && counts.mosaicTiles > 0 && counts.mosaicTiles === state.mosaicTiles;
  await until("the dive of now", read, isShown("survey"), 180);

  await t.test("is opened from the list of dives, whole and where it was", async () => {
    await openDive("earlier");
    await keep(page, "dive-sheet");
    assert.deepEqual(await tooSmall(page), []);
    await tap(page, item("Look at it"));
    await page.waitForURL(/dive=/);
    const { counts } = await until("the earlier dive", read, isShown("earlier"), 120);
    const wanted = harness.diveJson(earlier).counts;
    assert.deepEqual([counts.cameras, counts.planes, counts.tiePoints], [wanted.oriented, wanted.planes, wanted.tie_points]);
    const lines = readFileSync(path.join(earlier, "trajectory.tum"), "utf8").split("\n").filter((line) => /^[0-9]/.test(line));
    const places = lines.map((line) => line.split(" ").slice(1, 4).map(Number));
    const shown = await page.evaluate((images) => [...Array(images).keys()].map(window.nadir.placeOf), places.length);
    const worst = Math.max(...shown.map((place, i) => Math.hypot(...place.map((x, k) => x - places[i][k]))));
    assert.ok(worst < 1e-4, `off by ${worst}`);
  });

  await t.test("is drawn", async () => {
    const drawn = async () => (await page.locator("#canvas").screenshot()).length;
    assert.ok(await page.evaluate(() => window.nadir.fitMosaic(0)));
    await pause(1000);
    const mosaic = await drawn();
    await tap(page, "nav >> text=Layers");
    await tap(page, "role=switch[name='Mosaic']");
    await tap(page, "nav >> text=Layers");
    await pause(500);
    assert.ok(mosaic > 2 * (await drawn()), `${mosaic} bytes with the mosaic`);
    await tap(page, "nav >> text=3D");
    await pause(1500);
    await keep(page, "recorded-3D");
    assert.ok((await drawn()) > mosaic / 4, "planes");
    await tap(page, "nav >> text=Map");
    await tap(page, "nav >> text=Layers");
    await tap(page, "role=switch[name='Mosaic']");
    await tap(page, "nav >> text=Layers");
  });

  await t.test("says so, shows no dials and no advice, and cries nothing", async () => {
    assert.match(await banner(), /Recorded dive\s+earlier\s+40 images, read to its end/);
    for (const gauge of ["recording", "altitude", "speed", "overlap", "clock"]) {
      assert.equal(await page.locator(`.gauge.${gauge}`).isVisible(), false, gauge);
    }
    assert.equal(await page.locator(".gauge.tracking .value").innerText(), "Mapped");
    assert.equal(await page.locator("#live").isVisible(), false);
    assert.equal(await page.locator("#guide .gap").isVisible(), false);
    assert.equal(await page.locator("#alerts .alert").count(), 0);
    for (const [held, viewport] of [["portrait", harness.PORTRAIT], ["landscape", harness.LANDSCAPE]]) {
      await page.setViewportSize(viewport);
      await pause(500);
      await keep(page, `recorded-${held}`);
      assert.deepEqual(await tooSmall(page), [], held);
      assert.deepEqual(await barriers(page), [], held);
    }
  });

  await t.test("gives way to the live view at one touch", async () => {
    await tap(page, ".recorded >> text=Back to the live view");
    await page.waitForURL((url) => url.search === "");
    await until("the dive of now", read, isShown("survey"), 60);
    assert.equal(new URL(page.url()).search, "");
    assert.equal(await page.locator(".recorded").count(), 0);
    assert.equal(await page.locator(".gauge.altitude").isVisible(), true);
  });

  await t.test("gives its files", async () => {
    await openDive("earlier");
    for (const name of ["trajectory.tum", "mosaic-000.png"]) {
      const [download] = await Promise.all([page.waitForEvent("download"), tap(page, item(name))]);
      assert.equal(download.suggestedFilename(), name);
      const file = path.join(earlier, name.startsWith("mosaic") ? "mosaic2d" : "", name);
      assert.deepEqual(readFileSync(await download.path()), readFileSync(file), name);
    }
    await tap(page, "#panel [aria-label=Close]");
  });

  await t.test("tells what is damaged, and what helps", async () => {
    await openDive("damaged");
    await tap(page, item("Look at it"));
    await page.waitForURL(/dive=/);
    await page.waitForSelector("#alerts .alert[data-level=bad]", { timeout: 120_000 });
    assert.match(await page.locator("#alerts .alert").innerText(), /damaged: \d+ records? of its journal.+nadir recover/s);
    await keep(page, "recorded-damaged");
    assert.ok((await read()).counts.mosaicTiles > 0);
    await tap(page, "#alerts >> text=Seen");
    await tap(page, ".recorded >> text=Back to the live view");
    await page.waitForURL((url) => url.search === "");
    await until("the dive of now", read, isShown("survey"), 60);
  });

  await t.test("is deleted by who controls, once they are sure", async () => {
    const remove = async () => {
      await openDive("earlier");
      await tap(page, item("Delete"));
      await tap(page, item("Delete for ever"));
    };
    await remove();
    await page.waitForSelector("#panel .outcome:has-text('control')");
    assert.ok(existsSync(earlier));
    await tap(page, "#panel [aria-label=Close]");
    await tap(page, "nav >> text=Menu");
    await tap(page, item("Dive"));
    await tap(page, item("Take control"));
    await page.waitForSelector(item("Give control back"));
    await tap(page, "#panel [aria-label=Close]");
    await remove();
    await until("its removal", () => existsSync(earlier), (there) => !there, 20);
    await page.waitForSelector(item("earlier"), { state: "detached" });
  });

  // What it said no to is an error to the browser's console.
  assert.deepEqual(errors.filter((error) => !error.includes("409")), []);
  run.stop();
  await run.ended;
});

/** Spoils a byte in the middle of a file. */
function damage(file) {
  const bytes = readFileSync(file);
  bytes[bytes.length >> 1] ^= 0xff;
  writeFileSync(file, bytes);
}
