// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A WebSocket whose far end is the test.
import { golden } from "./golden";

export class FakeSocket {
  binaryType = "";
  sent: ArrayBuffer[] = [];
  onopen?: (() => void) | null;
  onmessage?: ((message: { data: unknown }) => void) | null;
  onclose?: (() => void) | null;
  close(): void {
    this.isClosed = true;
  }
  isClosed = false;
  send(bytes: ArrayBuffer): void {
    this.sent.push(bytes);
  }
}

/** The server's answer to a hello. */
export function welcome(feed: bigint): ArrayBuffer {
  const bytes = golden("welcome");
  new DataView(bytes).setBigUint64(16, feed, true);
  return bytes;
}
