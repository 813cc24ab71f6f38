// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { decode } from "./wire/decode";
import { encodeHello } from "./wire/hello";
import type { Alert, Welcome } from "./wire/records";

/** Alerts once more, by a connection of their own: where packets are lost, one that the link waits for does not hold them up.
 *  Should this one fail, the link brings them all the same. */
export class AlertLine {
  private socket: WebSocket | null = null;

  constructor(
    private readonly address: string,
    private readonly onAlert: (alert: Alert & { sequence: number }) => void,
    private readonly open: (address: string) => WebSocket = (to) => new WebSocket(to),
  ) {}

  /** Those that come to be after a welcome, of the same feed. */
  follow({ feed, newest }: Welcome): void {
    this.end();
    const socket = this.open(this.address);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      socket.send(encodeHello(feed, BigInt(newest)));
    };
    socket.onmessage = ({ data }: MessageEvent<unknown>) => {
      const record = data instanceof ArrayBuffer ? decode(data) : null;
      if (record?.type === "alert") this.onAlert(record);
      else if (record?.type === "welcome" && record.feed !== feed) this.end();
    };
  }

  end(): void {
    if (this.socket === null) return;
    this.socket.onopen = this.socket.onmessage = null;
    this.socket.close();
    this.socket = null;
  }
}
