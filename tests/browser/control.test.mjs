// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Who may command, and marks: the device's own screen, a tablet that scanned the code, one that did not.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import path from "node:path";
import test from "node:test";
import * as harness from "./harness.mjs";
import { keep, tap, until } from "./harness.mjs";

const NOTE = "anchor, 2 m";
const folder = harness.temporaryFolder();
const survey = path.join(folder, "survey");
const dive = path.join(folder, "dive");
assert.deepEqual(harness.missing, [], "not there");
harness.simulate(survey, "--scene", "pool", "--images", "40", "--stereo", "--seed", "7");

const open = async (page, ...items) => {
  await tap(page, "nav >> text=Menu");
  for (const item of items) await tap(page, `#panel .wide:has(.label:text-is('${item}'))`);
};
const panel = (page) => page.locator("#panel").innerText();
/** A pin moves with the map, which makes room for what is new: it may not be in sight yet. */
const tapPin = (page, pin, note = NOTE) =>
  until("what the mark says", async () => {
    await page.locator(pin).tap({ force: true }).catch(() => undefined); // a fault's words name the mark too
    return panel(page);
  }, (text) => text.includes(note), 20);

test("control of the device", { timeout: 300_000 }, async (t) => {
  const port = await harness.freePort();
  const browser = await harness.chromium();
  t.after(() => browser.close());
  const run = await harness.replay(survey, dive, port, "--rate", "0.3", "--keep-serving");
  const own = await harness.openPage(browser, port);
  const device = `http://${harness.DEVICE}:${port}/`;
  const stranger = await harness.openPage(browser, port, undefined, harness.PORTRAIT, device);
  const pin = `.pin[aria-label='Mark: ${NOTE}']`;

  await t.test("is not for a page that does not know the code", async () => {
    await open(stranger.page, "Dive");
    await stranger.page.locator("#panel >> text=scan the code").waitFor();
    assert.equal(await stranger.page.locator("#panel .wide").count(), 0);
    await tap(stranger.page, "#panel [aria-label=Close]");
    await open(stranger.page, "Code for a tablet");
    await stranger.page.locator("#panel >> text=shown on the device's own screen only").waitFor();
    await tap(stranger.page, "#panel [aria-label=Close]");
    const answer = await stranger.page.evaluate(() => fetch("api/token").then(({ status }) => status));
    assert.equal(answer, 403);
  });

  await t.test("is taken on the device's own screen, and all pages say by whom", async () => {
    await open(own.page, "Dive");
    await own.page.locator("#panel input").fill("Ada");
    await tap(own.page, "#panel .wide:has(.label:text-is('Take control'))");
    await own.page.locator("#panel >> text=In control: this screen").waitFor();
    await keep(own.page, "control");
    assert.match(await panel(own.page), /This is a replay/);
    await tap(own.page, "#panel [aria-label=Close]");
    await open(stranger.page, "Dive");
    await stranger.page.locator("#panel >> text=In control: Ada").waitFor();
    await tap(stranger.page, "#panel [aria-label=Close]");
  });

  await t.test("lets a hand mark a place, with its photograph, for everybody", async () => {
    await until("a map", own.read, ({ state }) => state?.oriented > 8, 60);
    await tap(own.page, "nav >> text=Tools");
    await tap(own.page, "#panel .wide:has(.label:text-is('Mark a point'))");
    const [x, y] = await own.page.evaluate(() => window.nadir.placeOf(6));
    const at = await own.page.evaluate(([x, y]) => window.nadir.screenOf(x, y, 0), [x, y]);
    await own.page.touchscreen.tap(at.x, at.y);
    await own.page.locator("#panel textarea").fill(NOTE);
    await keep(own.page, "mark-note");
    await tap(own.page, "#panel .wide:has(.label:text-is('Save'))");
    await own.page.locator(pin).waitFor();
    await stranger.page.locator(pin).waitFor();
    const lies = await own.page.locator(pin).evaluate((element) => {
      const { left, top, width, height } = element.getBoundingClientRect();
      return { x: left + width / 2, y: top + height / 2 };
    });
    assert.ok(Math.hypot(lies.x - at.x, lies.y - at.y) < 60, `${JSON.stringify(lies)} for ${JSON.stringify(at)}`);
    await tapPin(stranger.page, pin);
    const photo = stranger.page.locator("#panel img.photo");
    await photo.waitFor();
    await until("the photograph", () => photo.evaluate(({ naturalWidth }) => naturalWidth), (width) => width > 100, 20);
    assert.match(await panel(stranger.page), new RegExp(NOTE));
    await keep(stranger.page, "mark");
    await tap(stranger.page, "#panel .wide:has(.label:text-is('Remove'))");
    await stranger.page.locator("#panel .outcome:has-text('scan the code')").waitFor();
    await tap(stranger.page, "#panel [aria-label=Close]");
  });

  await t.test("shows marks to who comes late, as long as they are there", async () => {
    const late = await harness.openPage(browser, port, undefined, harness.PORTRAIT, device);
    await late.page.locator(pin).waitFor();
    await tapPin(own.page, pin);
    await tap(own.page, "#panel .wide:has(.label:text-is('Remove'))");
    await late.page.locator(pin).waitFor({ state: "detached" });
    await tap(own.page, "nav >> text=Tools");
    await tap(own.page, "#panel .wide:has(.label:text-is('Mark here'))");
    await own.page.locator("#panel textarea").fill("kept");
    // The device takes its time, the hand does not: one mark.
    await own.page.route("**/api/marks", async (route) => {
      await harness.pause(700);
      await route.continue();
    });
    await own.page.locator("#panel .wide:has(.label:text-is('Save'))").evaluate((save) => {
      for (let i = 0; i < 3; ++i) save.click();
    });
    await late.page.locator(".pin[aria-label='Mark: kept']").waitFor();
    await late.page.close();
  });

  await t.test("opens nothing for an answer that comes late", async () => {
    let answered;
    await own.page.route("**/api/dives", async (route) => {
      await harness.pause(700);
      await route.continue();
      answered = true;
    });
    await open(own.page, "Dives");
    await tap(own.page, "#panel [aria-label=Close]");
    await until("the answer", () => answered, (come) => come === true, 10);
    await harness.pause(500);
    assert.equal(await own.page.locator("#panel").isVisible(), false);
    await own.page.unroute("**/api/dives");
  });

  await t.test("goes to a tablet by the code that the own screen shows", async () => {
    const given = await own.page.evaluate(() => fetch("api/token").then((answer) => answer.json()));
    const scanned = `${device}#token=${given.token}`;
    const tablet = await harness.openPage(browser, port, undefined, harness.PORTRAIT, scanned);
    assert.equal(new URL(tablet.page.url()).hash, "", "nobody reads it over a shoulder");
    await open(tablet.page, "Dive");
    await tablet.page.locator("#panel input").fill("Bob");
    await tap(tablet.page, "#panel .wide:has(.label:text-is('Take control'))");
    await tablet.page.locator("#panel >> text=Ada controls").waitFor();
    await tap(tablet.page, "#panel .wide:has(.label:text-is('Take over'))");
    await tablet.page.locator("#panel >> text=In control: this screen").waitFor();
    await tap(tablet.page, "#panel [aria-label=Close]");
    await open(own.page, "Dive");
    await own.page.locator("#panel >> text=In control: Bob").waitFor();
    await tap(own.page, "#panel [aria-label=Close]");
    await open(tablet.page, "Dive");
    await tap(tablet.page, "#panel .wide:has(.label:text-is('Give control back'))");
    await tablet.page.locator("#panel >> text=Nobody controls").waitFor();
    // A link with a wrong code, from wherever it came, takes nothing away.
    for (const wrong of ["x".repeat(43), "", "x"]) {
      await tablet.page.goto("about:blank");
      await tablet.page.goto(`${device}#token=${wrong}`);
      await until("the code kept", () => tablet.page.evaluate(() => localStorage.getItem("nadir.token")), (kept) => kept === given.token, 5);
    }
    await open(tablet.page, "Dive");
    await tap(tablet.page, "#panel .wide:has(.label:text-is('Take control'))");
    await tablet.page.locator("#panel >> text=In control: this screen").waitFor();
    assert.deepEqual(tablet.errors.filter((error) => !/40[19]/.test(error)), []);
    await tablet.page.close();
  });

  await t.test("had no error to report", () => {
    assert.deepEqual(own.errors.filter((error) => !/409/.test(error)), [], "but for the control it lost");
    assert.deepEqual(stranger.errors.filter((error) => !/40[13]/.test(error)), []);
  });
  run.stop();
  await run.ended;

  await t.test("comes back to the own screen when the device has begun anew with another code", async () => {
    const begin = async (name) => {
      const run = await harness.replay(survey, path.join(folder, name), port, "--rate", "0.3", "--keep-serving");
      t.after(run.stop);
      return run;
    };
    const take = async () => {
      await until("the link", own.read, ({ link, state }) => link === "live" && state?.finished === false, 30);
      await open(own.page, "Dive");
      await tap(own.page, "#panel .wide:has(.label:text-is('Take control'))");
    };
    await own.page.route("**/api/token", (route) => route.fulfill({ json: { token: "x".repeat(43) } }));
    const first = await begin("another");
    await take();
    await own.page.locator("#panel .outcome:has-text('code')").waitFor();
    await tap(own.page, "#panel [aria-label=Close]");
    first.stop();
    await first.ended;
    await own.page.unroute("**/api/token");
    const second = await begin("again");
    await take();
    await own.page.locator("#panel >> text=In control: this screen").waitFor();
    second.stop();
    await second.ended;
  });

  await t.test("leaves marks that a recorded dive shows, with their photographs", async () => {
    const next = await harness.replay(survey, path.join(folder, "next"), port, "--rate", "0.3", "--keep-serving");
    t.after(next.stop);
    const dives = await (await fetch(`http://127.0.0.1:${port}/api/dives`)).json();
    const { id } = dives.find(({ name }) => name === "dive");
    const recorded = await harness.openPage(browser, port, undefined, harness.PORTRAIT, `http://127.0.0.1:${port}/?dive=${id}`);
    await tapPin(recorded.page, ".pin[aria-label='Mark: kept']", "kept");
    const photo = recorded.page.locator("#panel img.photo");
    await until("the photograph", () => photo.evaluate(({ naturalWidth }) => naturalWidth), (width) => width > 100, 20);
    assert.equal(await recorded.page.locator("#panel .wide").count(), 0, "nothing to be removed");
    await keep(recorded.page, "recorded-mark");
    assert.deepEqual(recorded.errors, []);
    next.stop();
    await next.ended;
  });
  const marks = readFileSync(path.join(dive, "marks.jsonl"), "utf8").trim().split("\n").map((line) => JSON.parse(line));
  assert.deepEqual(marks.map(({ note }) => note), ["kept"]);
});
