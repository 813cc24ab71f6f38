// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Whether an eye or a hand in a glove can use the page as it is now.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const TOUCH_PX = 88; // 15 mm on a 10-inch tablet
const TEXT_PX = 16;

const axe = readFileSync(createRequire(new URL("../../web/package.json", import.meta.url)).resolve("axe-core/axe.min.js"), "utf8");

/** Faults of accessibility that keep somebody from using the page. */
export async function barriers(page) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  const serious = violations.filter(({ impact }) => impact === "serious" || impact === "critical");
  return serious.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 120)).join(" | ")}`);
}

/** What can be touched and is smaller than a finger in a glove, and text that is too small. */
export const tooSmall = (page) =>
  page.evaluate(
    ([touch, text]) => {
      const shown = (element) => element.checkVisibility({ visibilityProperty: true });
      const name = (element) => `${element.tagName} ${element.className} ${element.textContent.slice(0, 30)}`;
      const targets = [...document.querySelectorAll("button, a, input, textarea, [role=switch]")].filter(shown);
      const small = targets.filter((target) => {
        const { width, height } = target.getBoundingClientRect();
        return width < touch - 0.5 || height < touch - 0.5;
      });
      const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
      const fine = [];
      while (walker.nextNode()) {
        const parent = walker.currentNode.parentElement;
        if (walker.currentNode.textContent.trim() === "" || !shown(parent) || parent.tagName === "SCRIPT") continue;
        if (parseFloat(getComputedStyle(parent).fontSize) < text) fine.push(parent);
      }
      return [...small.map(name), ...fine.map((element) => `text of ${name(element)}`)];
    },
    [TOUCH_PX, TEXT_PX],
  );
