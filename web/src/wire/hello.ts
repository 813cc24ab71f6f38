// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { HEADER_SIZE, VERSION } from "./records";

/** The first message to a server: the feed this page knows, and up to where it has everything of it. */
export function encodeHello(feed: bigint, complete: bigint): ArrayBuffer {
  const message = new DataView(new ArrayBuffer(HEADER_SIZE + 16));
  message.setUint8(0, 1);
  message.setUint8(1, VERSION);
  message.setBigUint64(HEADER_SIZE, feed, true);
  message.setBigUint64(HEADER_SIZE + 8, complete, true);
  return message.buffer;
}
