// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a diver is told and may command, on a tablet held either way: node --test tests/browser
import assert from "node:assert/strict";
import { cpSync, existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import test from "node:test";
import { barriers, tooSmall } from "./fitness.mjs";
import * as harness from "./harness.mjs";
import { keep, pause, tap, until } from "./harness.mjs";
import { alert, HEADER, measures, missing, NEWS, oriented, recording } from "./wire_records.mjs";

const IMAGES = 18;
const RATE = 1.5;
/** This survey, 2 m over dim ground, is then given advice. */
const UNWANTED = ["guide.altitude_low=50", "guide.overlap_low=0.99", "odometry.weak_sharpness=100000", "odometry.weak_dark=229"];

const folder = harness.temporaryFolder();
const survey = path.join(folder, "survey");
const dives = path.join(folder, "dives");
const dive = path.join(dives, "now");
assert.deepEqual(harness.missing, [], "not there");
harness.simulate(survey, "--scene", "transect", "--images", String(IMAGES));

const item = (label) => `#panel .wide:has(.label:text-is('${label}'))`;
const open = async (page, ...items) => {
  await tap(page, "nav >> text=Menu");
  for (const label of items) await tap(page, item(label));
};
const close = (page) => tap(page, "#panel [aria-label=Close]");
const panel = (page) => page.locator("#panel").innerText();
const gauge = (page, name) =>
  page.locator(`.gauge.${name}`).evaluate((one) => ({
    shown: one.checkVisibility(),
    value: one.querySelector(".value").innerText,
    advice: one.querySelector(".advice").innerText,
    level: one.dataset.level,
    isMarked: one.querySelector(".badge .icon") !== null,
  }));
/** Dials of which not all can be read. */
const cutOff = (page) =>
  page.$$eval(".gauge", (all) =>
    all
      .flatMap((one) => [...one.querySelectorAll(".label, .value, .advice")])
      .filter((part) => part.checkVisibility() && (part.scrollHeight > part.clientHeight + 1 || part.scrollWidth > part.clientWidth + 1))
      .map((part) => `${part.closest(".gauge").className}: ${part.innerText}`),
  );
const advice = async (page, name) => {
  const { level, advice, isMarked } = await gauge(page, name);
  return [level, advice, isMarked];
};

const faults = async (page) => [...(await barriers(page)), ...(await tooSmall(page))];

/** A page that shows the dive; what else it is told is said by say(). */
async function diversPage(browser, port, viewport, { vibrates = true } = {}) {
  let line;
  let state;
  const opened = await harness.openPage(
    browser,
    port,
    async (page) => {
      await page.addInitScript(stubCries, vibrates);
      await page.routeWebSocket(/feed/, (socket) => {
        line = socket;
        socket.connectToServer().onMessage((message) => {
          if (message[0] === 3) state = Buffer.from(message);
          socket.send(message);
        });
      });
    },
    viewport,
  );
  await until("the dive", opened.read, isWhole, 30);
  const time = state.readBigInt64LE(HEADER + 16);
  return { ...opened, state, time, say: (record) => line.send(record), cries: () => opened.page.evaluate(() => window.cries) };
}

/** Notes tones and vibrations in place of making them. In the page. */
function stubCries(vibrates) {
  window.cries = { tones: [], vibrations: [] };
  delete Navigator.prototype.vibrate;
  if (vibrates) Navigator.prototype.vibrate = (pattern) => window.cries.vibrations.push(pattern.map(Math.round)) > 0;
  window.AudioContext = class {
    state = "running";
    currentTime = 0;
    destination = null;
    createGain() {
      return { gain: { value: 1 }, connect: () => undefined };
    }
    createOscillator() {
      const frequency = { value: 0 };
      return { frequency, connect: () => undefined, start: () => window.cries.tones.push(frequency.value), stop: () => undefined };
    }
  };
}

const isWhole = ({ counts, state }) => state?.finished === true && counts.cameras > 0 && counts.mosaicTiles === state.mosaicTiles;
const levelled = async (page, name, level) => {
  await page.waitForSelector(`.gauge.${name}[data-level=${level}]`);
  return gauge(page, name);
};

test("a diver's page", { timeout: 300_000 }, async (t) => {
  const port = await harness.freePort();
  const line = await harness.lineTo(port);
  const browser = await harness.chromium();
  t.after(async () => {
    line.close();
    await browser.close();
  });
  const settings = ["odometry.initial_images=3", ...UNWANTED].flatMap((setting) => ["--set", setting]);
  const run = await harness.replay(survey, dive, port, "--rate", String(RATE), "--keep-serving", ...settings);
  t.after(run.stop);
  const greetings = [];
  const far = await harness.openPage(browser, line.port, (page) => {
    page.on("websocket", (socket) => {
      if (!socket.url().endsWith("/feed")) return;
      const greeting = {};
      greetings.push(greeting);
      socket.on("framesent", ({ payload }) => (greeting.hello ??= Buffer.from(payload)));
      socket.on("framereceived", ({ payload }) => (greeting.welcome ??= Buffer.from(payload)));
    });
  });

  await t.test("says in words that it is not up to date once the line is cut", async () => {
    await until("a map that grows", far.read, ({ counts, state }) => counts.cameras > 0 && state.finished === false, 60);
    await far.page.waitForSelector("body[data-link=live]");
    line.cut();
    await far.page.waitForSelector("body[data-link=lost]");
    const told = await until("what it says", () => gauge(far.page, "recording"), ({ value }) => value === "No link", 5);
    assert.deepEqual([told.level, told.advice], ["warning", "what you see is not up to date"]);
    await keep(far.page, "stale");
  });

  await t.test("goes on in the midst of a dive where the line broke off, and ends with all of it", async () => {
    const before = await far.read();
    line.mend();
    await far.page.waitForSelector("body[data-link=live]");
    assert.equal((await far.read()).state.finished, false, "the dive was over before");
    await until("the dive", far.read, (now) => {
      for (const name of ["cameras", "tiePoints", "planes"]) {
        assert.ok(now.counts[name] >= before.counts[name], `${name} was forgotten`);
      }
      return now.state.finished;
    }, 60);
    const { counts } = harness.diveJson(dive);
    const wanted = { cameras: counts.oriented, tiePoints: counts.tie_points, planes: counts.planes, mosaicTiles: counts.mosaic_tiles };
    assert.ok(wanted.cameras > before.counts.cameras, "nothing came after the cut");
    await until("all of it", far.read, (now) => JSON.stringify(now.counts) === JSON.stringify(wanted), 20);
    const helloed = greetings.filter(({ welcome }) => welcome !== undefined);
    assert.equal(helloed.length, 2);
    const [first, second] = helloed.map(({ hello, welcome }) => ({
      known: hello.readBigUInt64LE(HEADER),
      complete: hello.readBigUInt64LE(HEADER + 8),
      feed: welcome.readBigUInt64LE(HEADER),
    }));
    assert.deepEqual([first.known, first.complete], [0n, 0n]);
    assert.equal(second.known, first.feed);
    assert.equal(second.feed, first.feed);
    assert.ok(second.complete > 0n, "all is sent anew");
    assert.equal((await gauge(far.page, "recording")).value, "Dive ended");
  });

  await t.test("advises to go higher and slower where the device's settings want that", async () => {
    assert.deepEqual(await advice(far.page, "altitude"), ["warning", "go higher", true]);
    assert.deepEqual(await advice(far.page, "overlap"), ["warning", "slower", true]);
  });

  await t.test("warns of blurred and dark images where the device's settings call them so", async () => {
    await tap(far.page, "nav >> text=Image");
    assert.equal(await far.page.locator("#picture .warnings").innerText(), "blurred: slower · more light");
    assert.deepEqual(far.errors.filter((error) => !/ERR_|WebSocket/.test(error)), [], "but for the line that was cut");
  });
  await far.page.close();

  const earlier = path.join(dives, "earlier");
  cpSync(dive, earlier, { recursive: true });
  for (const [held, viewport] of [
    ["landscape", harness.LANDSCAPE],
    ["portrait", harness.PORTRAIT],
  ]) {
    const { page, errors, say, cries, state, time } = await diversPage(browser, port, viewport);

    await t.test(`held in ${held}, shows what is known of the dive and the board`, async () => {
      const utc = 1_800_000_000;
      say(recording(1, { saved: 1234, began: time - 754_000_000_000n }));
      say(measures({ depth: [12.34], heading: [Math.PI / 2], battery: [0.8, 0.3], free_space: [64e9, 1e9], utc: [utc] }));
      const recorded = await levelled(page, "recording", "good");
      assert.equal(recorded.value, "Recording");
      assert.match(recorded.advice, /^64 GB left · 1.234 saved$/);
      const shown = [];
      for (const name of ["depth", "heading", "battery", "clock"]) shown.push(await gauge(page, name));
      assert.ok(shown.every((one) => one.shown));
      const timeOfDay = new Date(1000 * utc).toTimeString().slice(0, 5);
      assert.deepEqual(shown.map(({ value }) => value), ["12.3 m", "090°", "80 %", timeOfDay]);
      assert.deepEqual([shown[2].level, shown[2].isMarked, shown[3].advice], ["good", false, "12:34"]);
      await keep(page, `gauges-${held}`);
      assert.deepEqual(await faults(page), []);
    });

    await t.test(`held in ${held}, shows no dial of what is not known`, async () => {
      say(measures({}));
      for (const name of ["depth", "heading", "battery"]) {
        await page.locator(`.gauge.${name}`).waitFor({ state: "hidden" });
      }
      for (const name of ["altitude", "speed", "overlap"]) {
        const { shown, value, level } = await gauge(page, name);
        assert.deepEqual([shown, value, level], [true, "–", "plain"], name);
      }
      const { value, advice } = await gauge(page, "clock");
      assert.deepEqual([value, advice], ["12:34", "dive time"]);
      assert.match((await gauge(page, "recording")).advice, /^1.234 saved$/);
    });

    await t.test(`held in ${held}, makes a low battery and a dive that is not recorded stand out`, async () => {
      say(measures({ battery: [0.12, 0.3] }));
      const battery = await levelled(page, "battery", "warning");
      assert.deepEqual([battery.value, battery.advice, battery.isMarked], ["12 %", "low", true]);
      say(recording(2));
      const paused = await levelled(page, "recording", "bad");
      assert.deepEqual([paused.value, paused.isMarked], ["Not recording", true]);
      await keep(page, `low-${held}`);
      assert.deepEqual(await faults(page), []);
      say(recording(1));
      await levelled(page, "recording", "good");
    });

    await t.test(`held in ${held}, says how long the disk lasts, and all of it can be read`, async () => {
      say(measures({ depth: [12.3], heading: [1], battery: [0.8, 0.3], free_space: [5e8, 1e9], recording_left: [125, 600], utc: [1_800_000_000] }));
      say(missing(state, 12));
      const told = () => gauge(page, "recording").then((one) => one.advice);
      await until("what is left", told, (words) => /^0.5 GB, 2:05 left · 12 missing · 120 saved$/.test(words), 5);
      await keep(page, `left-${held}`);
      assert.deepEqual(await cutOff(page), []);
    });

    await t.test(`held in ${held}, does not call mapped what is not`, async () => {
      const tracking = async (wanted) => until(wanted, () => gauge(page, "tracking"), ({ value }) => value === wanted, 5);
      say(oriented(state, 0));
      const { level, advice } = await tracking("Not mapped");
      assert.deepEqual([level, advice], ["warning", "see Alerts"]);
      say(state);
      await tracking("Mapped");
    });

    await t.test(`held in ${held}, makes a disk that is nearly full stand out`, async () => {
      assert.notEqual((await gauge(page, "recording")).level, "good");
    });

    await t.test(`held in ${held}, advises to go closer, farther and slower`, async () => {
      say(measures({ altitude: [0.6, 1, 3], speed: [0.2, null, 0.4], overlap: [0.8, 0.6] }));
      await levelled(page, "altitude", "warning");
      assert.deepEqual(await advice(page, "altitude"), ["warning", "go higher", true]);
      assert.deepEqual(await advice(page, "speed"), ["good", "", false]);
      assert.deepEqual(await advice(page, "overlap"), ["good", "", false]);
      say(measures({ altitude: [3.5, 1, 3], speed: [0.5, null, 0.4], overlap: [0.4, 0.6] }));
      await levelled(page, "speed", "warning");
      assert.deepEqual(await advice(page, "altitude"), ["warning", "go lower", true]);
      assert.deepEqual(await advice(page, "speed"), ["warning", "slower", true]);
      assert.deepEqual(await advice(page, "overlap"), ["warning", "slower", true]);
      await keep(page, `advice-${held}`);
    });

    await t.test(`held in ${held}, warns in the image of blur and of too much or too little light`, async () => {
      const warnings = page.locator("#picture .warnings");
      const says = (wanted) => until("its warnings", () => warnings.textContent(), (found) => found === wanted, 5);
      say(missing(state, 0));
      await tap(page, "nav >> text=Image");
      say(measures({ blur: [0.5, null, 1], brightness: [0.5, 0.1, 0.9] }));
      await says("");
      assert.equal(await warnings.isVisible(), false);
      say(measures({ blur: [3, null, 1], brightness: [0.95, 0.1, 0.9] }));
      await says("blurred: slower · too bright");
      say(measures({ blur: [0.5, null, 1], brightness: [0.05, 0.1, 0.9] }));
      await says("more light");
      assert.equal(await warnings.isVisible(), true);
      await keep(page, `warned-${held}`);
      assert.deepEqual(await faults(page), []);
      await tap(page, "nav >> text=Map");
    });

    await t.test(`held in ${held}, warns of that beside the map, too, and of nothing when all is well`, async () => {
      const warnings = page.locator("#live .warnings");
      assert.equal(await warnings.innerText(), "more light");
      say(measures({ brightness: [0.5, 0.1, 0.9] }));
      await until("its warnings", () => warnings.textContent(), (found) => found === "", 5);
      assert.equal(await warnings.isVisible(), false);
    });

    await t.test(`held in ${held}, cries an alert across the screen, with sound and vibration, until it is seen`, async () => {
      const banner = page.locator("#alerts .alert");
      const bubble = page.locator("nav .tool:has-text('Alerts') .bubble");
      const before = await cries();
      say(alert(901, NEWS, "storage", "the disk is full", "end the dive and make room"));
      await banner.filter({ hasText: "the disk is full" }).waitFor();
      assert.equal(await banner.getAttribute("data-level"), "bad");
      assert.equal(await banner.locator(".remedy").innerText(), "end the dive and make room");
      const { width, across } = await banner.evaluate((one) => ({
        width: one.getBoundingClientRect().width,
        across: document.querySelector("main").clientWidth,
      }));
      assert.ok(width > 0.9 * across, `${width} of ${across} px`);
      assert.equal(await bubble.innerText(), "1");
      const cried = await cries();
      assert.deepEqual(cried.tones.slice(before.tones.length), [880, 660, 880, 660]);
      assert.deepEqual(cried.vibrations.slice(before.vibrations.length), [[167, 56, 167, 56, 167, 56, 167, 56]]);
      await keep(page, `alert-${held}`);
      assert.deepEqual(await faults(page), []);
      say(alert(902, NEWS + 1, "camera_lost", "the camera gives no images", "check its cable"));
      await banner.filter({ hasText: "the camera gives no images" }).waitFor();
      assert.equal(await banner.locator(".more").innerText(), "1 more");
      assert.equal(await bubble.innerText(), "2");
      await tap(page, "#alerts >> text=Seen");
      await banner.filter({ hasText: "the disk is full" }).waitFor();
      assert.equal(await bubble.innerText(), "1");
      await tap(page, "#alerts >> text=Seen");
      await banner.waitFor({ state: "detached" });
      assert.equal(await bubble.isVisible(), false);
      await tap(page, "nav >> text=Alerts");
      assert.match(await panel(page), /the camera gives no images\s+check its cable.+the disk is full\s+end the dive and make room/s);
      await close(page);
    });

    await t.test(`held in ${held}, shows an alert of before it was there, without a cry`, async () => {
      const before = await cries();
      say(alert(903, 1, "storage", "the card is old", "take another"));
      await tap(page, "#alerts .alert:has-text('the card is old') >> text=Seen");
      assert.deepEqual(await cries(), before);
    });

    await t.test(`held in ${held}, leaves an alert and a sheet within reach, however long, also when it is turned`, async () => {
      await open(page, "Display");
      say(alert(906, NEWS + 2, "storage", "the disk is full ".repeat(30), `${"W".repeat(400)} make room`));
      await page.locator("#alerts .alert:has-text('the disk is full')").waitFor();
      for (const size of [viewport, { width: viewport.height, height: viewport.width }, viewport]) {
        await page.setViewportSize(size);
        await pause(200);
        const reached = await page.evaluate(() =>
          ["#alerts .seen", "#panel .dismiss"].map((one) => {
            const { left, top, width, height } = document.querySelector(one).getBoundingClientRect();
            return document.elementFromPoint(left + width / 2, top + height / 2)?.closest(one) !== null;
          }),
        );
        assert.deepEqual(reached, [true, true], JSON.stringify(size));
      }
      await keep(page, `long-alert-${held}`);
      await tap(page, "#alerts >> text=Seen");
      await close(page);
    });

    await t.test(`held in ${held}, is silent once sound is switched off`, async () => {
      const sound = page.locator("role=switch[name='Sound and vibration']");
      await open(page, "Display");
      await sound.tap();
      assert.equal(await sound.getAttribute("aria-checked"), "false");
      await close(page);
      const before = await cries();
      say(alert(904, NEWS + 3, "storage", "the disk is slow", "take another"));
      await page.locator("#alerts .alert:has-text('the disk is slow')").waitFor();
      assert.deepEqual(await cries(), before);
      await tap(page, "#alerts >> text=Seen");
      await open(page, "Display");
      await sound.tap();
      await close(page);
      assert.ok((await cries()).tones.length > before.tones.length, "its own tone");
    });

    await t.test(`held in ${held}, has a form for a mark that a glove can fill in`, async () => {
      await tap(page, "nav >> text=Tools");
      await tap(page, item("Mark here"));
      await page.locator("#panel textarea").waitFor();
      await keep(page, `mark-form-${held}`);
      assert.deepEqual(await faults(page), []);
      await close(page);
    });

    await t.test(`held in ${held}, asks before it deletes a dive, in a way that a glove can answer`, async () => {
      await open(page, "Dives", "earlier", "Delete");
      assert.match(await panel(page), /Delete earlier with all its images and maps\?/);
      await keep(page, `delete-${held}`);
      assert.deepEqual(await faults(page), []);
      await close(page);
      assert.ok(existsSync(earlier));
    });

    await t.test(`held in ${held}, commands the dive, each command once and with the device's code`, async () => {
      const posts = [];
      await page.route("**/api/**", async (route) => {
        const request = route.request();
        if (request.method() !== "POST") return route.continue();
        posts.push([new URL(request.url()).pathname, request.headers().authorization]);
        await pause(200);
        return route.fulfill({ status: 200, body: "" });
      });
      const { token } = await (await fetch(`http://127.0.0.1:${port}/api/token`)).json();
      const posted = async (address, act) => {
        posts.length = 0;
        await Promise.all([page.waitForResponse(new RegExp(`/api/${address}$`)), act()]);
        await pause(100);
        assert.deepEqual(posts, [[`/api/${address}`, `Bearer ${token}`]]);
      };
      /** As often as an impatient hand can before the page answers. */
      const hit = (selector) => async () => {
        await page.locator(selector).waitFor();
        await page.locator(selector).evaluate((one) => {
          for (let i = 0; i < 3; ++i) one.click();
        });
      };
      const isSaid = (words) => page.locator(`#panel >> text=${words}`).waitFor();

      say(recording(0));
      await open(page, "Dive");
      await posted("control/take", () => tap(page, item("Take control")));
      await isSaid("In control: this screen");
      assert.equal(await page.locator(item("End the dive")).count(), 0);
      await posted("dive/start", () => tap(page, item("Start a dive")));
      await isSaid("Done at");
      say(recording(1));
      await posted("dive/submap", () => tap(page, item("New part of the map")));
      assert.equal(await page.locator(item("Start a dive")).count(), 0);
      await keep(page, `control-${held}`);
      posts.length = 0;
      await tap(page, item("End the dive"));
      await isSaid("What was recorded is kept");
      await tap(page, "#panel [aria-label=Back]");
      await tap(page, item("End the dive"));
      await page.locator("#panel .wide.danger").waitFor();
      assert.deepEqual(posts, [], "it asks first");
      await posted("dive/stop", () => tap(page, "#panel .wide.danger"));
      say(recording(3));
      await tap(page, item("Shut down"));
      await isSaid("End the dive and switch the device off");
      assert.deepEqual(posts.slice(1), [], "it asks first");
      await keep(page, `shut-down-${held}`);
      assert.deepEqual(await faults(page), []);
      await posted("shutdown", hit("#panel .wide.danger"));
      await isSaid("Done at");
      await posted("control/release", () => tap(page, item("Give control back")));
      await close(page);
    });

    await t.test(`held in ${held}, had no error to report`, () => assert.deepEqual(errors, []));
    await page.close();
  }

  await t.test("cries alerts where nothing can vibrate, too", async () => {
    const { page, errors, say, cries } = await diversPage(browser, port, harness.PORTRAIT, { vibrates: false });
    await tap(page, "nav >> text=Map");
    assert.equal(await page.evaluate(() => "vibrate" in navigator), false);
    say(alert(905, NEWS, "storage", "the disk is full", "end the dive and make room"));
    const told = await page.locator("#alerts .alert:has-text('the disk is full')").waitFor({ timeout: 5000 }).then(() => "told", () => "untold");
    assert.deepEqual([told, errors], ["told", []]);
    assert.equal(await page.locator("nav .tool:has-text('Alerts') .bubble").innerText(), "1");
    assert.deepEqual((await cries()).tones, [880, 660, 880, 660]);
    await page.close();
  });
  run.stop();
  await run.ended;

  // No camera, and yet the board is to be switched off from the page.
  await t.test("has the board power off, once somebody is sure", async () => {
    const own = path.join(folder, "runtime");
    mkdirSync(own);
    const config = path.join(folder, "nadir.toml");
    writeFileSync(config, `[capture]\ncalibration = '${path.join(folder, "none.yml")}'\n[record]\ndives = '${dives}'\n`);
    const device = await harness.serving(["run", "--config", config, "--serve", `127.0.0.1:${port}`], {
      NOTIFY_SOCKET: "@nadir-browser-diver",
      RUNTIME_DIRECTORY: own,
    });
    t.after(device.stop);
    const { page, errors } = await harness.openPage(browser, port);
    const request = path.join(own, "power-off");
    await open(page, "Dive", "Take control", "Shut down");
    await page.locator("#panel >> text=switch the device off").waitFor();
    assert.equal(existsSync(request), false, "it asks first");
    await tap(page, "#panel .wide.danger");
    await until("the request", () => existsSync(request), (there) => there, 10);
    await page.locator("#alerts .alert:has-text('the board powers off')").waitFor();
    await keep(page, "powers-off");
    assert.deepEqual(errors, []);
    device.stop();
    await device.ended;
  });
});
