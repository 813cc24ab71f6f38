// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from "vitest";
import { Store, type Kept } from "../src/view/store";

const MB = 1 << 20;

async function content({ bytes }: Kept): Promise<Uint8Array> {
  return bytes instanceof Blob ? new Uint8Array(await bytes.arrayBuffer()) : bytes;
}

describe("Store", () => {
  it("gives back what it keeps, the oldest from files", async () => {
    const store = new Store();
    const kept = Array.from({ length: 40 }, (_, i) => store.keep(new Uint8Array(3 * MB).fill(i)));
    const inFiles = kept.map(({ bytes }) => bytes instanceof Blob);
    expect(inFiles.slice(0, 20)).not.toContain(false);
    expect(inFiles.slice(-10)).not.toContain(true);
    for (const [i, one] of kept.entries()) {
      const bytes = await content(one);
      expect(bytes.length).toBe(3 * MB);
      expect([bytes[0], bytes.at(-1)]).toEqual([i, i]);
    }
  });

  it("makes no file of what is dropped before", async () => {
    const store = new Store();
    for (let i = 0; i < 40; ++i) store.drop(store.keep(new Uint8Array(3 * MB)));
    const last = store.keep(new Uint8Array([7]));
    expect(last.bytes).not.toBeInstanceOf(Blob);
    expect(await content(last)).toEqual(new Uint8Array([7]));
  });
});
