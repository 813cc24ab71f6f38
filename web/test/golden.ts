// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { readFileSync } from "node:fs";

/** The bytes the server's own tests compare with. */
export const GOLDEN = new URL("../../tests/wire/golden/", import.meta.url);

export function golden(name: string): ArrayBuffer {
  return new Uint8Array(readFileSync(new URL(`${name}.bin`, GOLDEN))).buffer;
}
