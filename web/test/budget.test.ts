// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Budget, QUALITIES } from "../src/view/budget";

describe("budget", () => {
  beforeEach(() => vi.useFakeTimers());
  afterEach(() => vi.useRealTimers());

  function move(budget: Budget, pictures: number, interval: number, from = 0): number {
    let now = from;
    for (let i = 0; i < pictures; ++i) budget.begin((now += interval));
    return now;
  }

  it("draws in full while pictures are quick", () => {
    const budget = new Budget();
    const now = move(budget, 100, 16);
    expect(budget.begin(now + 16)).toBe(QUALITIES[0]);
  });

  it("gets coarser while pictures are slow, and no coarser than it must", () => {
    const budget = new Budget();
    const now = move(budget, 12, 100);
    expect(budget.begin(now + 100)).toBe(QUALITIES[2]);
    move(budget, 100, 35, now);
    expect(budget.begin(now + 100 * 35)).toBe(QUALITIES[2]);
  });

  it("gets finer again once pictures are quick", () => {
    const budget = new Budget();
    const now = move(budget, 100, 100);
    expect(budget.begin(now + 100)).toBe(QUALITIES[4]);
    expect(budget.begin(move(budget, 30, 16, now + 100) + 16)).toBe(QUALITIES[0]);
  });

  it("asks for one picture in full when the hand rests", () => {
    const budget = new Budget();
    let rests = 0;
    budget.onRest = () => ++rests;
    const now = move(budget, 20, 100);
    vi.advanceTimersByTime(1000);
    expect(rests).toBe(1);
    expect(budget.begin(now + 1000)).toBe(QUALITIES[0]);
    vi.advanceTimersByTime(1000);
    expect(rests).toBe(1);
    expect(budget.begin(now + 3000)).not.toBe(QUALITIES[0]);
  });
});
