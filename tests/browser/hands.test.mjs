// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Every tool of the page in a hand: guidance, layers, 3D, keys, the code, the page kept: node --test tests/browser
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import http from "node:http";
import path from "node:path";
import test from "node:test";
import decodeQR from "../../web/node_modules/qr/decode.js";
import { difference, drag, isAgain, pixelsOf, still } from "./canvas.mjs";
import * as harness from "./harness.mjs";
import { keep, pause, tap, until } from "./harness.mjs";
import { COVERAGE } from "./sources.mjs";
import { coverageTile, guidanceIn, poseIn } from "./wire_records.mjs";

const IMAGES = 12;
/** The survey's path leads along the third of four lanes. */
const PLAN = { length: 4.5, width: 4, lanes: 4, bearing: 332, corner: [-2.05, -1.98] };
const LANE = 3;
const MOST_BYTES = 400_000;

const folder = harness.temporaryFolder();
const survey = path.join(folder, "survey");
const dive = path.join(folder, "dive");
assert.deepEqual(harness.missing, [], "not there");

const pressed = (page, tool) => page.locator(`nav .tool:has-text('${tool}')`).getAttribute("aria-pressed");
const stage = (page) => page.evaluate(() => document.body.dataset.stage);
const hint = (page) => page.locator("#hint .text").innerText();
const screenOf = (page, place) => page.evaluate(([x, y, z]) => window.nadir.screenOf(x, y, z), place);
const apart = (one, other) => Math.hypot(...one.map((x, k) => x - other[k]));
const between = (one, other) => Math.hypot(one.x - other.x, one.y - other.y);

const layer = (name) => `role=switch[name='${name}']`;
/** Turns layers on or off in the open sheet, and what is on then of those asked for. */
async function flip(page, names, asked = names) {
  for (const name of names) await tap(page, layer(name));
  return Promise.all(asked.map(async (name) => (await page.locator(layer(name)).getAttribute("aria-checked")) === "true"));
}

/** Between a page and its device: keeps what is told of guidance and poses, the wire's own words, and holds back the
 *  images after a number, so that the vehicle moves when a test wants it to. */
class Gate {
  guidance = null;
  poses = new Map();
  #open = 2;
  #held = new Map();
  #socket = null;

  async put(page) {
    await page.routeWebSocket(/feed/, (socket) => {
      this.#socket = socket;
      socket.connectToServer().onMessage((message) => {
        if (message[0] === 19) this.guidance = guidanceIn(message);
        if (message[0] !== 6) return socket.send(message);
        const image = Number(message.readBigUInt64LE(16));
        this.poses.set(image, poseIn(message));
        if (image <= this.#open) socket.send(message);
        else this.#held.set(image, message);
      });
    });
  }

  /** Lets the images pass up to a number. */
  let(last) {
    this.#open = last;
    for (const [image, message] of [...this.#held].sort(([one], [other]) => one - other)) {
      if (image > last) continue;
      this.#held.delete(image);
      this.#socket.send(message);
    }
  }
}

/** A vector turned by the unit quaternion x, y, z, w. */
function turned([x, y, z, w], v) {
  const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
  const once = cross([x, y, z], v).map((value, k) => value + w * v[k]);
  return cross([x, y, z], once).map((value, k) => v[k] + 2 * value);
}

const lines = (name) => readFileSync(path.join(survey, name), "utf8").trim().split("\n").filter((line) => !/^(#|id|frame)/.test(line));

/** The survey's targets on the seabed: where they truly are, where in the map (by a pose that shows them), and the images they are in. */
function targetsIn(poses) {
  const numbersOf = (line) => line.split(/\s+/).map(Number);
  const truth = lines("gt_poses_tum.txt").map(numbersOf).map(([, x, y, z, ...rotation]) => ({ position: [x, y, z], rotation }));
  const sights = lines("gt_observations.csv").map((line) => line.split(",")).filter(([, side]) => side === "left");
  return lines("gt_points.csv").map((line) => {
    const [id, ...numbers] = line.split(",");
    const inWorld = numbers.slice(0, 3).map(Number);
    const images = sights.filter(([, , which]) => which === id).map(([image]) => Number(image));
    const image = images[images.length >> 1];
    const { position, rotation: [x, y, z, w] } = truth[image];
    const inCamera = turned([-x, -y, -z, w], inWorld.map((value, k) => value - position[k]));
    const pose = poses.get(image);
    const inMap = turned(pose.rotation, inCamera).map((value, k) => value + pose.position[k]);
    return { inWorld, inMap, images };
  });
}

/** Bytes that come over the line for a file, as a browser asks for it. */
const bytesOf = (address) =>
  new Promise((resolve, reject) => {
    http.get(address, { headers: { "Accept-Encoding": "gzip" } }, (answer) => {
      let count = 0;
      answer.on("data", (part) => (count += part.length));
      answer.on("end", () => resolve({ status: answer.statusCode, count, told: Number(answer.headers["content-length"]) }));
    }).on("error", reject);
  });

test("the page in a hand", { timeout: 300_000 }, async (t) => {
  harness.simulate(survey, "--scene", "pool", "--images", String(IMAGES), "--stereo", "--seed", "7");
  const port = await harness.freePort();
  const browser = await harness.chromium();
  t.after(() => browser.close());
  const judge = await browser.newPage();
  const { length, width, lanes, bearing, corner: [x, y] } = PLAN;
  const plan = { length, width, lane_spacing: width / lanes, bearing_deg: bearing, corner_x: x, corner_y: y };
  const settings = Object.entries(plan).flatMap(([key, value]) => ["--set", `plan.${key}=${value}`]);
  const begin = (into) => harness.replay(survey, into, port, "--serve", `0.0.0.0:${port}`, "--keep-serving", ...settings);
  const run = await begin(dive);
  const gate = new Gate();
  const own = await harness.openPage(browser, port, (page) => gate.put(page));
  const { page } = own;

  /** The newest image, where the vehicle and the map's origin are on the page, and the middle of what no card hides. */
  const vehicle = () =>
    page.evaluate((last) => {
      let image = last;
      while (image >= 0 && window.nadir.placeOf(image) === null) --image;
      if (image < 0) return { image };
      const { left, top, width } = document.getElementById("canvas").getBoundingClientRect();
      const bottom = document.getElementById("guide").getBoundingClientRect().top;
      const [x, y, z] = window.nadir.placeOf(image);
      const [at, origin] = [window.nadir.screenOf(x, y, z), window.nadir.screenOf(0, 0, 0)];
      return { image, at, origin, middle: { x: left + width / 2, y: (top + bottom) / 2 } };
    }, IMAGES - 1);
  const NEAR_PX = 80;

  await t.test("follows the vehicle at a touch of Follow, until a hand moves the map", async () => {
    const begun = await until("a map", vehicle, ({ image }) => image === 2, 60);
    assert.ok(between(begun.at, begun.middle) > NEAR_PX, "the whole plan is shown");
    assert.equal(await pressed(page, "Follow"), "false");
    await tap(page, "nav >> text=Follow");
    assert.equal(await pressed(page, "Follow"), "true");
    const isNear = ({ at, middle }) => between(at, middle) < NEAR_PX / 2;
    const first = await until("the middle", vehicle, isNear, 10);
    for (const image of [4, 6, 8]) {
      gate.let(image);
      await until(`image ${image}`, vehicle, (now) => now.image === image && isNear(now), 10);
    }
    await keep(page, "follow");
    const last = await vehicle();
    assert.ok(between(first.origin, last.origin) > NEAR_PX, `the map moved by ${between(first.origin, last.origin)} px only`);
    await drag(page, [[last.middle.x, last.middle.y], [last.middle.x - 200, last.middle.y + 60]]);
    assert.equal(await pressed(page, "Follow"), "false");
    const left = await vehicle();
    assert.ok(between(left.at, last.at) > NEAR_PX, "the map goes where it is dragged");
    gate.let(10);
    const later = await until("another image", vehicle, ({ image }) => image === 10, 10);
    await pause(500);
    assert.ok(between(left.origin, (await vehicle()).origin) < 2 && between(left.at, later.at) > 20, "and stays there");
  });

  await t.test("follows at the key F, until A", async () => {
    await page.keyboard.press("f");
    assert.equal(await pressed(page, "Follow"), "true");
    await until("the middle", vehicle, ({ at, middle }) => between(at, middle) < NEAR_PX / 2, 10);
    gate.let(IMAGES);
    await until("the last image", vehicle, ({ image, at, middle }) => image === IMAGES - 1 && between(at, middle) < NEAR_PX / 2, 10);
    await page.keyboard.press("a");
    assert.equal(await pressed(page, "Follow"), "false");
    await until("all of it", vehicle, ({ at, middle }) => between(at, middle) > NEAR_PX, 10);
  });

  const { url, token } = await (await fetch(`http://127.0.0.1:${port}/api/token`)).json();
  const scanned = new Set();
  await t.test("shows a code that a camera reads, held either way, by day and by night", async () => {
    for (const [held, themes] of [[harness.PORTRAIT, ["night", "dark"]], [harness.LANDSCAPE, ["dark"]]]) {
      await page.setViewportSize(held);
      await tap(page, "nav >> text=Menu");
      await tap(page, "#panel .wide:has(.label:text-is('Code for a tablet'))");
      const code = page.locator("#panel canvas.code");
      await code.waitFor();
      for (const theme of themes) {
        await page.evaluate((name) => (document.documentElement.dataset.theme = name), theme);
        await code.scrollIntoViewIfNeeded();
        await keep(page, `code-${theme}-${held.width}`);
        scanned.add(decodeQR(await pixelsOf(judge, await code.screenshot())));
      }
      assert.deepEqual([await page.locator("#panel .address").innerText()], [...scanned]);
      await tap(page, "#panel [aria-label=Close]");
    }
    assert.ok([...scanned][0].startsWith(url), [...scanned][0]);
  });

  await t.test("puts the device's token into the code, as nadir token does", () => {
    assert.deepEqual([...scanned], [`${url.split("#")[0]}#token=${token}`]);
  });

  await until("finished", own.read, ({ state }) => state?.finished === true, 60);
  await until("its tiles", own.read, ({ counts, state }) => counts.mosaicTiles === state.mosaicTiles, 60);
  const upright = await harness.openPage(browser, port, undefined, harness.PORTRAIT);
  await until("its tiles", upright.read, ({ counts, state }) => state !== null && counts.mosaicTiles === state.mosaicTiles, 60);

  for (const [held, { page: shown }] of [["landscape", own], ["portrait", upright]]) {
    await t.test(`says on which lane the vehicle is, and how far beside it, in ${held}`, async () => {
      const lane = shown.locator("#guide .lane");
      assert.ok(await lane.isVisible());
      const [, at, of, where] = /^lane (\d+) of (\d+): (.+)$/.exec(await lane.innerText()) ?? [];
      assert.deepEqual([at, of].map(Number), [LANE, PLAN.lanes]);
      const place = await shown.evaluate((image) => window.nadir.placeOf(image), IMAGES - 1);
      const bearing = (PLAN.bearing * Math.PI) / 180;
      const right = (place[0] - PLAN.corner[0]) * Math.cos(bearing) - (place[1] - PLAN.corner[1]) * Math.sin(bearing);
      const off = right - ((LANE - 0.5) * PLAN.width) / PLAN.lanes;
      const [, distance, side] = /^([\d.]+) m to the (left|right)$/.exec(where) ?? [];
      const said = where === "on it" ? 0 : side === "left" ? Number(distance) : -Number(distance);
      assert.ok(Math.abs(said - off) < (where === "on it" ? 0.06 : 0.02), `${where} for ${off}`);
    });

    await t.test(`points the way to the nearest gap, in ${held}`, async () => {
      const [gap] = gate.guidance.gaps;
      const { position, rotation } = gate.poses.get(IMAGES - 1);
      const before = gate.poses.get(IMAGES - 3).position;
      const clockwise = ([x, y]) => Math.atan2(x, y);
      const forward = clockwise(turned(rotation, [0, -1, 0]));
      assert.ok(Math.cos(forward - clockwise([0, 1].map((k) => position[k] - before[k]))) > 0.7, "the image's top is where it swims to");
      const way = [0, 1].map((k) => gap.centre[k] - position[k]);
      const arrow = shown.locator("#guide svg");
      assert.ok(await arrow.isVisible());
      const angle = await arrow.evaluate((svg) => {
        const [, value, unit] = /^(-?[\d.e-]+)(rad|deg)$/.exec(getComputedStyle(svg).rotate);
        return unit === "deg" ? (value * Math.PI) / 180 : Number(value);
      });
      assert.ok(Math.cos(angle - (clockwise(way) - forward)) > 0.9999, `${angle} for ${clockwise(way) - forward}`);
      const [, distance, area] = /^gap ([\d.]+) m, ([\d.]+) m²$/.exec(await shown.locator("#guide .gap").innerText()) ?? [];
      assert.ok(distance > 0 && Math.abs(distance - Math.hypot(...way)) < 0.006, `${distance} for ${Math.hypot(...way)}`);
      assert.ok(Math.abs(area - gap.area) < 0.06, `${area} for ${gap.area}`);
      await keep(shown, `guide-${held}`);
    });

    await t.test(`draws the plan, and how often the ground was seen, where that is wanted, in ${held}`, async () => {
      const names = ["Plan and lanes", "Coverage and gaps"];
      await tap(shown, "#zoom >> text=Farther"); // the eye stays where it is then
      await tap(shown, "nav >> text=Layers");
      const all = await still(shown);
      let last = all;
      for (const name of names) {
        assert.deepEqual(await flip(shown, [name]), [false]);
        const without = await still(shown);
        const count = await difference(judge, last, without);
        assert.ok(count > 1500, `${name}: only ${count} px`);
        last = without;
      }
      assert.deepEqual(await flip(shown, names), [true, true]);
      await isAgain(shown, judge, all);
      await tap(shown, "nav >> text=Layers");
    });

    await t.test(`lets no card hide another, in ${held}`, async () => {
      const hidden = await shown.evaluate(() => {
        const cards = ["scale", "guide", "zoom", "live"].map((id) => [id, document.getElementById(id).getBoundingClientRect()]);
        const overlap = ([, a], [, b]) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
        return cards.flatMap((one, i) => cards.slice(i + 1).filter((other) => overlap(one, other)).map(([id]) => `${one[0]} and ${id}`));
      });
      assert.deepEqual(hidden, []);
    });

    await t.test(`warns of nothing at the small image where nothing is wrong, in ${held}`, async () => {
      const warnings = shown.locator("#live .warnings");
      assert.deepEqual([await warnings.textContent(), await warnings.isVisible()], ["", false]);
    });
  }

  await t.test("colours the ground by how often it was seen, as its legend says", async () => {
    // Beside the map; each value eight cells wide, the upper half nothing.
    const tile = { column: 2, row: -1, cell: 0.02 };
    const values = [128, 1, 2, 3, 127, 129, 130, 131];
    const row = Array.from({ length: 64 }, (_, i) => values[i >> 3]);
    const record = coverageTile(tile, Array.from({ length: 64 }, (_, i) => (i < 32 ? row.map(() => 0) : row)));
    const golden = readFileSync(new URL("../wire/golden/coverage_tile.bin", import.meta.url));
    assert.deepEqual(record.subarray(0, 2), golden.subarray(0, 2));
    let isSent = false;
    const { page: told, errors } = await harness.openPage(browser, port, (one) =>
      one.routeWebSocket(/feed/, (socket) => {
        socket.connectToServer().onMessage((message) => {
          socket.send(message);
          if (message[0] !== 14 || isSent) return;
          isSent = true;
          socket.send(record);
        });
      }),
    );
    await until("the record", () => isSent, Boolean, 60);
    await still(told);
    const place = (column, line) => [tile.cell * (64 * tile.column + column + 0.5), -tile.cell * (64 * tile.row + line + 0.5), 0];
    // To the middle, and closer.
    const at = await screenOf(told, place(32, 32));
    const middle = { x: 590, y: 350 }; // of what no card hides
    await told.mouse.move(middle.x, middle.y);
    await told.mouse.down();
    await told.mouse.move(2 * middle.x - at.x, 2 * middle.y - at.y, { steps: 5 });
    await told.mouse.up();
    await tap(told, "#zoom >> text=Closer");
    const shot = await pixelsOf(judge, (await still(told), await told.screenshot()));
    await keep(told, "coverage-colours");
    const ground = [0x0b, 0x14, 0x18];
    const seen = async (column, line) => {
      const { x, y } = await screenOf(told, place(column, line));
      const i = 4 * (Math.floor(y) * shot.width + Math.floor(x));
      return [...shot.data.subarray(i, i + 3)];
    };
    const isNear = (colour, wanted, what) =>
      assert.ok(Math.max(...colour.map((x, k) => Math.abs(x - wanted[k]))) <= 6, `${what}: ${colour} for ${wanted}`);
    const over = (index, alpha = COVERAGE[index][3]) => ground.map((dark, k) => dark + ((COVERAGE[index][k] - dark) * alpha) / 255);
    isNear(await seen(4, 16), ground, "where nothing was seen nor wanted");
    for (const [i, value] of values.entries()) {
      if (value === 128) continue;
      isNear(await seen(8 * i + 4, 48), over(Math.min(value % 128, 3)), `${value}`);
    }
    const stripes = await Promise.all([0, 1, 2, 3].map((i) => seen(2 + i, 46)));
    const reds = stripes.map(([red]) => red).sort((one, other) => one - other);
    isNear(stripes.find(([red]) => red === reds[3]), over(0), "a gap");
    assert.ok(reds[3] - reds[0] > 50, `a gap is striped: ${reds}`);
    await tap(told, "nav >> text=Layers");
    const legend = await told.$$eval("#panel .legend li", (all) =>
      all.map((item) => [item.innerText, item.querySelector(".swatch").style.getPropertyValue("--shade").match(/\d+/g).map(Number)]),
    );
    assert.deepEqual(legend, ["Gap", "1 view", "2 views", "3 and more"].map((text, i) => [text, COVERAGE[i].slice(0, 3)]));
    assert.deepEqual(errors, []);
    await told.close();
  });

  await t.test("does by its keys what its buttons do", async () => {
    const corners = () => page.evaluate(() => [window.nadir.screenOf(0, 0, 0), window.nadir.screenOf(1, 0, 0)]);
    const press = async (key) => {
      const before = await corners();
      await page.keyboard.press(key);
      await pause(100);
      const after = await corners();
      const length = ([a, b]) => between(a, b);
      return { shift: { x: after[0].x - before[0].x, y: after[0].y - before[0].y }, zoom: length(after) / length(before) };
    };
    for (const [key, name, tool] of [["3", "scene", "3D"], ["i", "picture", "Image"], ["m", "map", "Map"]]) {
      await page.keyboard.press(key);
      assert.equal(await stage(page), name);
      assert.equal(await pressed(page, tool), "true");
      assert.equal(await page.locator("#picture").isVisible(), key === "i");
    }
    await page.keyboard.press("f");
    assert.equal(await pressed(page, "Follow"), "true");
    await pause(1500);
    for (const [key, factor] of [["+", 1.4], ["=", 1.4], ["-", 1 / 1.4]]) {
      const { zoom } = await press(key);
      assert.ok(Math.abs(zoom - factor) < 0.01, `${key}: ${zoom}`);
    }
    assert.equal(await pressed(page, "Follow"), "true", "closer to what is followed");
    await page.focus("#canvas");
    for (const [key, x, y] of [["ArrowLeft", 1, 0], ["ArrowRight", -1, 0], ["ArrowUp", 0, 1], ["ArrowDown", 0, -1]]) {
      const { shift } = await press(key);
      assert.ok(shift.x * x + shift.y * y > 3 && Math.abs(shift.x * y) + Math.abs(shift.y * x) < 1, `${key}: ${JSON.stringify(shift)}`);
    }
    assert.equal(await pressed(page, "Follow"), "false", "a hand moved the map");
    for (let i = 0; i < 4; ++i) await page.keyboard.press("+");
    const outside = () =>
      page.evaluate((last) => {
        const { left, top, right, bottom } = document.getElementById("canvas").getBoundingClientRect();
        const places = [...Array(last + 1).keys()].map(window.nadir.placeOf).filter((place) => place !== null);
        return places.map(([x, y, z]) => window.nadir.screenOf(x, y, z)).filter(({ x, y }) => x < left || x > right || y < top || y > bottom).length;
      }, IMAGES - 1);
    assert.ok((await outside()) > 0);
    await page.keyboard.press("a");
    await until("all of it", outside, (count) => count === 0, 10);
    await pause(1500);

    await page.keyboard.press("3");
    const upward = () => page.evaluate(() => [window.nadir.screenOf(0, 0, 0), window.nadir.screenOf(0, 0, 1)]);
    const aside = between(...(await upward()));
    await page.keyboard.press("t");
    await pause(300);
    const above = between(...(await upward()));
    assert.ok(above < 0.5 * aside, `a metre's height is ${aside} px from aside, ${above} px from above`);
    await page.keyboard.press("m");

    const panel = page.locator("#panel");
    for (const [key, isOpen] of [["l", true], ["l", false], ["l", true], ["Escape", false], ["Escape", false]]) {
      await page.keyboard.press(key);
      assert.equal(await panel.isVisible(), isOpen, key);
      if (isOpen) assert.equal(await panel.locator("h2").innerText(), "Layers");
    }

    await tap(page, "nav >> text=Menu");
    await tap(page, "#panel .wide:has(.label:text-is('Dive'))");
    await page.locator("#panel input").fill("");
    await page.locator("#panel input").press("3");
    await page.locator("#panel input").press("i");
    assert.equal(await page.locator("#panel input").inputValue(), "3i");
    assert.equal(await stage(page), "map", "letters of a name command nothing");
    await tap(page, "#panel [aria-label=Close]");

    const focused = () =>
      page.evaluate(() => {
        const { activeElement: element } = document;
        return [element.closest("nav") === null ? "" : element.innerText, getComputedStyle(element).outlineStyle];
      });
    await page.focus("#canvas");
    let now = await focused();
    for (let i = 0; i < 30 && now[0] !== "Tools"; ++i) {
      await page.keyboard.press("Tab");
      now = await focused();
    }
    assert.deepEqual(now, ["Tools", "solid"], "a tool is reached, and it shows");
    await page.keyboard.press("Enter");
    assert.match(await panel.innerText(), /Ruler/);
    await keep(page, "keys");
    await page.keyboard.press("Escape");
  });

  await t.test("shows in 3D planes, points, mosaic, tie points and cameras, each where it is wanted", async () => {
    const { page: shown } = upright;
    await tap(shown, "nav >> text=3D");
    // So close that points stand apart; and the eye stays where it is then.
    for (let i = 0; i < 5; ++i) await tap(shown, "#zoom >> text=Closer");
    await tap(shown, "nav >> text=Layers");
    const styles = ["Image planes", "Planes as points"];
    const quads = await still(shown);
    await keep(shown, "3D-quads");
    const differ = async (one, other, what) => {
      const count = await difference(judge, one, other);
      assert.ok(count > 300, `${what}: only ${count} px`);
    };
    assert.deepEqual(await flip(shown, ["Planes as points"], styles), [false, true], "either");
    const points = await still(shown);
    await keep(shown, "3D-points");
    await differ(quads, points, "points");
    assert.deepEqual(await flip(shown, ["Image planes"], styles), [true, false], "or");
    assert.deepEqual(await flip(shown, ["Image planes"], styles), [false, false], "or neither");
    let last = await still(shown);
    await differ(quads, last, "no planes");
    await differ(points, last, "no points");
    await keep(shown, "3D-mosaic");
    for (const name of ["Mosaic", "Tie points", "Cameras and path"]) {
      assert.deepEqual(await flip(shown, [name]), [false]);
      const without = await still(shown);
      await differ(last, without, name);
      last = without;
    }
    await keep(shown, "3D-nothing");
    await flip(shown, ["Mosaic", "Tie points", "Cameras and path", "Image planes"]);
    await isAgain(shown, judge, quads);
    await tap(shown, "nav >> text=Layers");
    await tap(shown, "#zoom >> text=All");
    await still(shown);
  });

  const targets = targetsIn(gate.poses);
  const tapOn = async (shown, place) => {
    const at = await screenOf(shown, place);
    assert.equal(await shown.evaluate(({ x, y }) => document.elementFromPoint(x, y)?.id, at), "canvas", "no card lies over it");
    await shown.touchscreen.tap(at.x, at.y);
  };

  await t.test("measures in 3D from target to target, and how sure that is", async () => {
    const { page: shown } = upright;
    await tap(shown, "nav >> text=Tools");
    await tap(shown, "#panel >> text=Ruler");
    const [from, to] = [targets[0], targets.at(-1)];
    await tapOn(shown, from.inMap);
    await tapOn(shown, to.inMap);
    const [, length, sigma, unit] = /^([\d.]+) m ± ([\d.]+) (mm|cm|m)$/.exec(await hint(shown)) ?? [];
    const truth = apart(from.inWorld, to.inWorld);
    const metres = sigma * { mm: 1e-3, cm: 1e-2, m: 1 }[unit];
    await keep(shown, "3D-ruler");
    assert.ok(Math.abs(length - truth) < 3 * metres + 0.01, `${length} ± ${metres} for ${truth}`);
    assert.ok(metres > 0 && metres < 0.05 * truth, `± ${metres}`);
    await tap(shown, "#hint >> text=Done");
  });

  await t.test("says in 3D which image shows a target, when, from how far and how finely", async () => {
    const { page: shown } = upright;
    await tap(shown, "nav >> text=Tools");
    await tap(shown, "#panel >> text=What is here?");
    const target = targets[1];
    await tapOn(shown, target.inMap);
    const said = await hint(shown);
    await keep(shown, "3D-probe");
    const [, image, minutes, seconds, distance, pixel, count] =
      /^Image (\d+) at (\d+):(\d\d), ([\d.]+) m away, ([\d.]+) mm a pixel, seen by (\d+) images$/.exec(said) ?? [];
    assert.ok(target.images.includes(Number(image)), `${said} but it is in ${target.images}`);
    const time = Number(lines("timestamps.csv")[image].split(",")[1]);
    assert.equal(60 * minutes + Number(seconds), Math.floor(time));
    const away = apart(gate.poses.get(Number(image)).position, target.inMap);
    assert.ok(Math.abs(distance - away) < 0.03 * away, `${distance} for ${away}`);
    const [focal] = /data: \[ ([\d.]+)/.exec(readFileSync(path.join(survey, "calib.yml"), "utf8")).slice(1).map(Number);
    assert.ok(Math.abs(pixel - (1000 * away) / focal) < 0.06 * pixel, `${pixel} mm for ${(1000 * away) / focal}`);
    assert.ok(count >= target.images.length / 2, said);
    await tap(shown, "#hint >> text=Done");
  });

  await t.test("turns in 3D under a finger, moves under two and under the mouse's right button, and zooms by a pinch", async () => {
    const { page: shown } = upright;
    const place = targets[1].inMap;
    const beside = [place[0] + 1, place[1], place[2]];
    const ends = () => Promise.all([screenOf(shown, place), screenOf(shown, beside)]);
    const changed = async (act) => {
      const before = await ends();
      await act();
      const after = await ends();
      const [shift, other] = [0, 1].map((i) => ({ x: after[i].x - before[i].x, y: after[i].y - before[i].y }));
      return { shift, turned: between(shift, other), zoom: between(...after) / between(...before) };
    };
    const said = (what) => JSON.stringify(what);
    const isPan = ({ shift, turned, zoom }, x) =>
      Math.abs(shift.x - x) < 0.35 * Math.abs(x) && turned < 0.2 * Math.abs(x) && Math.abs(zoom - 1) < 0.15;
    const turn = await changed(() => drag(shown, [[300, 500], [420, 540]]));
    assert.ok(turn.turned > 20, `one finger turns: ${said(turn)}`);
    const two = await changed(() => drag(shown, [[300, 500], [400, 500]], [[420, 600], [520, 600]]));
    assert.ok(isPan(two, 100), `two fingers move: ${said(two)}`);
    const right = await changed(async () => {
      await shown.mouse.move(450, 500);
      await shown.mouse.down({ button: "right" });
      await shown.mouse.move(350, 500, { steps: 5 });
      await shown.mouse.up({ button: "right" });
      await pause(200);
    });
    assert.ok(isPan(right, -100), `the right button moves: ${said(right)}`);
    const left = await changed(async () => {
      await shown.mouse.move(450, 500);
      await shown.mouse.down();
      await shown.mouse.move(350, 480, { steps: 5 });
      await shown.mouse.up();
      await pause(200);
    });
    assert.ok(left.turned > 20, `the left one turns: ${said(left)}`);
    const pinch = await changed(() => drag(shown, [[350, 500], [270, 500]], [[450, 500], [530, 500]]));
    assert.ok(pinch.zoom > 1.5, `apart is closer: ${said(pinch)}`);
    const back = await changed(() => drag(shown, [[270, 500], [350, 500]], [[530, 500], [450, 500]]));
    assert.ok(back.zoom < 1 / 1.5, `together is farther: ${said(back)}`);
    await keep(shown, "3D-turned");
  });

  await t.test("had no error to report", () => {
    assert.deepEqual(own.errors, []);
    assert.deepEqual(upright.errors, []);
  });
  await page.close();
  await upright.page.close();

  const address = `http://localhost:${port}/`;
  const { page: kept, read, requests } = await harness.openPage(browser, port, undefined, harness.PORTRAIT, address);
  const manifestOf = () => kept.evaluate(async () => (await fetch(document.querySelector("link[rel=manifest]").href)).json());

  await t.test("takes little of a slow link", async () => {
    await kept.evaluate(async () => (await navigator.serviceWorker.ready).active !== null);
    const isKept = () => kept.evaluate(async () => (await (await caches.open("nadir")).keys()).map(({ url }) => url));
    const files = await until("what is kept", isKept, ({ length }) => length >= 5, 20);
    // All that a browser loads: what it asked for, what it keeps, what keeps it.
    const asked = requests.filter((url) => url.startsWith(address) && !url.includes("/api/"));
    const icons = (await manifestOf()).icons.map(({ src }) => new URL(src, address).href);
    const all = [...new Set([...files, ...asked, ...icons, `${address}sw.js`])];
    for (const kind of ["/", "page.js", ".css", "unpacker.js", "sw.js", ".webmanifest", ".svg"]) {
      assert.ok(all.some((url) => url.endsWith(kind)), `${kind} in ${all}`);
    }
    const sizes = await Promise.all(all.map((url) => bytesOf(url.replace("localhost", "127.0.0.1"))));
    sizes.forEach(({ status, count, told }, i) => assert.deepEqual([status, told], [200, count], all[i]));
    const bytes = sizes.reduce((sum, { count }) => sum + count, 0);
    if (process.env.NADIR_VERBOSE) console.log(all.map((url, i) => `${url} ${sizes[i].count}`).join("\n"), bytes);
    assert.ok(bytes <= MOST_BYTES, `the page takes ${bytes} bytes`);
  });

  await t.test("is kept on localhost: it stands without its device, says so, and comes back by itself", async () => {
    await until("a map", read, ({ counts }) => counts.cameras > 0, 30);
    run.stop();
    await run.ended;
    await kept.reload();
    assert.equal(await stage(kept), "map");
    assert.ok(await kept.locator("nav >> text=Layers").isVisible());
    const gauge = kept.locator(".gauge.recording");
    await until("no link", () => gauge.innerText(), (text) => text.includes("No link"), 20);
    await tap(kept, "nav >> text=Layers");
    assert.ok(await kept.locator("#panel .legend").isVisible(), "its buttons work");
    await keep(kept, "kept");
    const { name, start_url: start, icons: named } = await manifestOf();
    assert.deepEqual([name, start, named.length > 0], ["nadir", "./", true]);
    for (const { src } of named) {
      const width = await kept.evaluate(async (icon) => {
        const picture = Object.assign(new Image(), { src: icon });
        await picture.decode();
        return picture.width;
      }, new URL(src, address).href);
      assert.ok(width > 0, src);
    }

    const again = await begin(path.join(folder, "again"));
    await until("the link", read, ({ link, state, counts }) => link === "live" && state !== null && counts.cameras > 0, 30);
    await until("the link told", () => gauge.innerText(), (text) => !text.includes("No link"), 5);
    again.stop();
    await again.ended;
  });
});
