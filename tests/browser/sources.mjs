// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the page is made of says of its colours.
import { readFileSync } from "node:fs";

export const source = (name) => readFileSync(new URL(`../../web/src/${name}`, import.meta.url), "utf8");
/** Red, green, blue, alpha of a gap and of one, two, three and more views. */
export const COVERAGE = [...source("view/coverage.ts").split("COVERAGE_COLOURS = [")[1].split("as const")[0].matchAll(/\[([\d, ]+)\]/g)].map(
  ([, numbers]) => numbers.split(",").map(Number),
);
