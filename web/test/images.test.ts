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

  it("are tried once more when the thread that has them fails, and keep no other back", async () => {
    const { unpack, unpacking } = await import("../src/view/images");
    const outcomes: string[] = [];
    const one = async (name: string) =>
      unpack(PICTURE, null, []).then(() => outcomes.push(name), () => outcomes.push(`${name} failed`));
    const all = [one("first"), one("second")];
    const [before] = FakeWorker.all;
    before?.finish();
    await vi.advanceTimersByTimeAsync(1);
    expect(outcomes).toEqual(["first"]);
    before?.dispatchEvent(new Event("error"));
    all.push(one("third"));
    await vi.advanceTimersByTimeAsync(2000);
    const after = FakeWorker.all[1];
    expect(after?.jobs).toHaveLength(2);
    after?.dispatchEvent(new Event("error"));
    await vi.advanceTimersByTimeAsync(2000);
    expect(outcomes).toEqual(["first", "second failed"]);
    FakeWorker.all[2]?.finish();
    await Promise.all(all);
    expect(outcomes).toEqual(["first", "second failed", "third"]);
    expect(unpacking()).toBe(0);
  });
});
