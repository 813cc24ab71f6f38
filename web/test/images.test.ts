// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Job } from "../src/view/images";

/** A thread that does what it is told by a test. */
class FakeWorker extends EventTarget {
  static all: FakeWorker[] = [];
  jobs: Job[] = [];

  constructor() {
    super();
    FakeWorker.all.push(this);
  }

  postMessage(job: Job): void {
    this.jobs.push(job);
  }

  terminate(): void {
    this.jobs = [];
  }

  finish(): void {
    const job = this.jobs.shift();
    this.dispatchEvent(new MessageEvent("message", { data: { id: job?.id, width: 1, height: 1, pixels: [], bitmap: null } }));
  }
}

const PICTURE = new Uint8Array([0xff, 0xd8]);

describe("pictures", () => {
  beforeEach(() => {
    vi.useFakeTimers();
    vi.resetModules();
    FakeWorker.all = [];
    vi.stubGlobal("Worker", FakeWorker);
    vi.stubGlobal("navigator", { hardwareConcurrency: 1 });
  });
  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  /** What became of pictures that were asked for, in turn. */
  async function asked(): Promise<{ outcomes: string[]; ask: (name: string) => void; unpacking: () => number }> {
    const { unpack, unpacking } = await import("../src/view/images");
    const outcomes: string[] = [];
    const ask = (name: string) => void unpack(PICTURE, null, []).then(() => outcomes.push(name), () => outcomes.push(`${name} failed`));
    return { outcomes, ask, unpacking };
  }

  it("that a failed thread had are tried once more, each alone, and keep no other back", async () => {
    const { outcomes, ask, unpacking } = await asked();
    for (const name of ["first", "good", "bad", "fine"]) ask(name);
    const [before] = FakeWorker.all;
    before?.finish();
    await vi.advanceTimersByTimeAsync(1);
    before?.dispatchEvent(new Event("error"));
    ask("new");
    await vi.advanceTimersByTimeAsync(2000);
    const after = FakeWorker.all[1];
    expect(after?.jobs).toHaveLength(1);
    after?.finish();
    await vi.advanceTimersByTimeAsync(1);
    expect(after?.jobs).toHaveLength(1);
    after?.dispatchEvent(new Event("error"));  // by the bad one
    await vi.advanceTimersByTimeAsync(2000);
    expect(outcomes).toEqual(["first", "good", "bad failed"]);
    const last = FakeWorker.all[2];
    last?.finish();
    await vi.advanceTimersByTimeAsync(1);
    last?.finish();
    await vi.advanceTimersByTimeAsync(1);
    expect(outcomes).toEqual(["first", "good", "bad failed", "fine", "new"]);
    expect(unpacking()).toBe(0);
  });
});
