// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Pace } from "../src/view/pace";
import { Rounds } from "../src/view/rounds";

const FRAME_MS = 16;

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("requestAnimationFrame", (draw: (now: number) => void) => setTimeout(() => { draw(performance.now()); }, FRAME_MS));
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

/** A graphics card that takes so long for a picture. */
function card(takes: number): WebGL2RenderingContext {
  return {
    SIGNALED: 1,
    fenceSync: () => ({ done: performance.now() + takes }),
    getSyncParameter: ({ done }: { done: number }) => (performance.now() >= done ? 1 : 0),
    deleteSync: () => undefined,
    flush: () => undefined,
  } as unknown as WebGL2RenderingContext;
}

function paceOf(takes: number, moves = () => false): { pace: Pace; drawn: number[] } {
  const drawn: number[] = [];
  const pace = new Pace(card(takes), (now) => {
    drawn.push(now);
    return moves();
  });
  return { pace, drawn };
}

describe("the pace", () => {
  it("draws for a hand with the browser's next picture, however often it is asked", () => {
    const { pace, drawn } = paceOf(100);
    for (let i = 0; i < 5; ++i) pace.draw();
    vi.advanceTimersByTime(FRAME_MS);
    expect(drawn).toHaveLength(1);
    pace.draw();
    vi.advanceTimersByTime(FRAME_MS);
    expect(drawn).toHaveLength(2);
  });

  it("draws news in a quarter of the time", () => {
    const { pace, drawn } = paceOf(100);
    pace.draw();
    const end = performance.now() + 10_000;
    while (performance.now() < end) {
      pace.drawNews();
      vi.advanceTimersByTime(10);
    }
    // A picture takes 100 ms, and up to 40 until that is noticed and laid on the page.
    expect(drawn.length).toBeGreaterThan(10_000 / (4 * 140));
    expect(drawn.length).toBeLessThanOrEqual(1 + 10_000 / (4 * 100));
  });

  it("draws less of it while much is told", () => {
    const { pace, drawn } = paceOf(100);
    pace.isCatchingUp = () => true;
    pace.draw();
    const end = performance.now() + 10_000;
    while (performance.now() < end) {
      pace.drawNews();
      vi.advanceTimersByTime(10);
    }
    expect(drawn.length).toBeGreaterThan(4);
    expect(drawn.length).toBeLessThan(9);
  });

  it("is settled once the last that was asked for is drawn by the card", () => {
    const { pace } = paceOf(100);
    expect(pace.isSettled).toBe(true);
    pace.drawNews();
    expect(pace.isSettled).toBe(false);
    vi.advanceTimersByTime(90);
    expect(pace.isSettled).toBe(false);
    vi.advanceTimersByTime(100);
    expect(pace.isSettled).toBe(true);
  });

  it("goes on by itself while the scene moves", () => {
    let left = 3;
    const { pace, drawn } = paceOf(1, () => --left > 0);
    pace.draw();
    vi.advanceTimersByTime(1000);
    expect(drawn).toHaveLength(3);
    expect(pace.isSettled).toBe(true);
  });

  it("waits for no card longer than half a second", () => {
    const { pace, drawn } = paceOf(Infinity);
    pace.draw();
    vi.advanceTimersByTime(600);
    expect(pace.isSettled).toBe(true);
    pace.drawNews();
    vi.advanceTimersByTime(4 * 500 + 100);
    expect(drawn).toHaveLength(2);
  });
});

describe("rounds", () => {
  it("come four times a second while pictures do, and once more at rest", () => {
    const work = vi.fn();
    const rounds = new Rounds(work);
    for (let i = 0; i < 110; ++i) {
      rounds.soon(performance.now());
      vi.advanceTimersByTime(10);
    }
    const moving = work.mock.calls.length;
    expect(moving).toBeGreaterThanOrEqual(4);
    expect(moving).toBeLessThanOrEqual(6);
    vi.advanceTimersByTime(1000);
    expect(work).toHaveBeenCalledTimes(moving + 1);
  });

  it("do not come while they are held", () => {
    const work = vi.fn();
    const rounds = new Rounds(work);
    rounds.soon(performance.now());
    rounds.hold();
    vi.advanceTimersByTime(1000);
    expect(work).not.toHaveBeenCalled();
  });
});
