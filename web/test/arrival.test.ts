// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Arrival } from "../src/arrival";

describe("an arrival", () => {
  beforeEach(() => vi.useFakeTimers());
  afterEach(() => vi.useRealTimers());

  it("ends once, and begins anew with every link", () => {
    const ended = vi.fn();
    const arrival = new Arrival(ended);
    expect(arrival.isUnderWay).toBe(true);
    arrival.begin();
    arrival.end();
    arrival.end();
    expect(ended).toHaveBeenCalledTimes(1);
    arrival.begin();
    expect(arrival.isUnderWay).toBe(true);
    arrival.end();
    expect(ended).toHaveBeenCalledTimes(2);
  });

  it("ends by itself ten seconds after the last link came up", () => {
    const ended = vi.fn();
    const arrival = new Arrival(ended);
    arrival.begin();
    vi.advanceTimersByTime(9000);
    arrival.begin();
    vi.advanceTimersByTime(9999);
    expect(arrival.isUnderWay).toBe(true);
    vi.advanceTimersByTime(1);
    expect(arrival.isUnderWay).toBe(false);
    vi.advanceTimersByTime(60_000);
    expect(ended).toHaveBeenCalledTimes(1);
  });
});
