// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Who does not see red or green, or is under blue water, tells the page's colours apart all the same.
import assert from "node:assert/strict";
import test from "node:test";
import { COVERAGE, source } from "./sources.mjs";

// Severity 1 of Machado, Oliveira, Fernandes 2009, "A Physiologically-based Model for Simulation of Color Vision
// Deficiency", IEEE TVCG 15(6), for linear sRGB; and water that has taken nine tenths of the red.
const EYES = {
  "all cones": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  protanopia: [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
  deuteranopia: [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
  tritanopia: [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
  "blue water": [[0.1, 0, 0], [0, 1, 0], [0, 0, 1]],
};
/** CIE76: 2.3 is just noticeable side by side (Mahy 1994); four times that is told apart at a glance and from memory. */
const TOLD_APART = 10;
/** Where a shape tells the same, what is noticeable at all. */
const NOTICEABLE = 2.3;

const apart = (one, other) => Math.hypot(...one.map((x, k) => x - other[k]));
const times = (matrix, v) => matrix.map((row) => row.reduce((sum, x, k) => sum + x * v[k], 0));

/** CIE L*a*b* under D65 of what an eye makes of an sRGB colour. */
function lab(rgb, eye) {
  const linear = rgb.map((value) => value / 255).map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
  const seen = times(EYES[eye], linear).map((value) => Math.min(1, Math.max(0, value)));
  const xyz = times([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]], seen);
  const white = [0.9505, 1, 1.089];
  const root = (value) => (value > 0.008856 ? Math.cbrt(value) : 7.787 * value + 16 / 116);
  const [x, y, z] = xyz.map((value, k) => root(value / white[k]));
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

/** Pairs that an eye does not tell apart: {name: [red, green, blue]}. */
function confused(colours, least) {
  const pairs = Object.keys(colours).flatMap((one, i, all) => all.slice(i + 1).map((other) => [one, other]));
  return Object.keys(EYES).flatMap((eye) =>
    pairs
      .map(([one, other]) => ({ one, other, by: apart(lab(colours[one], eye), lab(colours[other], eye)) }))
      .filter(({ one, other, by }) => by <= least(one, other))
      .map(({ one, other, by }) => `${one} and ${other} to ${eye}: ${by.toFixed(1)}`),
  );
}

/** The colours of the levels in a theme of style.css. */
function levelColours(selector) {
  const [, block] = source("style.css").split(`\n${selector} {`);
  const hex = (name) => new RegExp(`--${name}: #(\\w+);`).exec(block.split("}")[0])[1];
  const long = (text) => (text.length === 3 ? [...text].map((digit) => digit + digit).join("") : text);
  const rgb = (text) => [0, 2, 4].map((i) => parseInt(long(text).slice(i, i + 2), 16));
  return Object.fromEntries(["good", "note", "warning", "bad"].map((name) => [name, rgb(hex(name))]));
}

/** Which icon an alert of a level has. */
function levelIcons() {
  const [, icons] = /ICONS: [^=]+= \{([^}]+)\}/.exec(source("ui/alerts.ts"));
  return Object.fromEntries([...icons.matchAll(/(\w+): "(\w+)"/g)].map(([, level, icon]) => [level, icon]));
}

test("colours that are told apart without red, green or blue", async (t) => {
  await t.test("tell how often the ground was seen", () => {
    assert.equal(COVERAGE.length, 4);
    const colours = Object.fromEntries(COVERAGE.map((colour, views) => [`${views} views`, colour.slice(0, 3)]));
    assert.deepEqual(confused(colours, () => TOLD_APART), []);
  });

  for (const [theme, selector] of [["dark", ":root"], ["light", '[data-theme="light"]']]) {
    await t.test(`tell how bad it is in the ${theme} theme, where icons do not`, () => {
      const icons = levelIcons();
      const least = (one, other) => (icons[one] === icons[other] ? TOLD_APART : NOTICEABLE);
      assert.deepEqual(confused(levelColours(selector), least), []);
    });
  }

  // Red light has one hue, and what is bright in it spoils the eye's use to the dark.
  await t.test("are not needed by night: icons tell how bad it is, or lightness does", () => {
    const icons = levelIcons();
    const colours = levelColours('[data-theme="night"]');
    const levels = Object.keys(colours);
    const alike = levels.flatMap((one, i) => levels.slice(i + 1).map((other) => [one, other])).filter(([one, other]) => {
      const step = Math.abs(lab(colours[one], "all cones")[0] - lab(colours[other], "all cones")[0]);
      return icons[one] === icons[other] && step < NOTICEABLE;
    });
    assert.deepEqual(alike, []);
  });
});
