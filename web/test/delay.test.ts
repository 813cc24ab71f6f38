// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { expect, it } from "vitest";
import { Delay } from "../src/ui/delay";
import type { State } from "../src/wire/records";

const at = (time: number, finished = false) => ({ time, finished }) as State;

it("a picture is late for as long as there have been newer ones", () => {
  const delay = new Delay();
  for (let i = 0; i <= 50; ++i) delay.setState(at(100 + i), 0.2 * i);
  expect(delay.of(150, 10)).toBe(0);
  delay.setState(at(151), 10.2);
  expect(delay.of(150, 12)).toBeCloseTo(1.8);
  delay.setState(at(152), 12.2);
  expect(delay.of(151, 12.3)).toBeCloseTo(0.1);
});

it("a picture is not late where images come seldom, or no more", () => {
  const delay = new Delay();
  delay.setState(at(1), 0);
  expect(delay.of(1, 60)).toBe(0);
  delay.setState(at(61), 60);
  expect(delay.of(1, 60)).toBe(0);
  delay.setState(at(61, true), 61);
  expect(delay.of(1, 120)).toBe(0);
});
