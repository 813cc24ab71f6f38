// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { decode } from "./wire/decode";
import { encodeHello } from "./wire/hello";
import type { Alert } from "./wire/records";

const RETRY_MS = 5000;

/** Alerts once more, by a connection of their own: where packets are lost, one that the link waits for does not hold them up.
 *  Should this one fail, the link brings them all the same. */
export class AlertLine {
  private socket: WebSocket | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly address: string,
    private readonly onAlert: (alert: Alert & { sequence: number }) => void,
    private readonly open: (address: string) => WebSocket = (to) => new WebSocket(to),
  ) {}

  /** From where the link has everything of a feed: both begin at one place, so whichever is first brings them in their order. */
  follow(feed: bigint, complete: () => bigint): void {
    this.end();
    const socket = this.open(this.address);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      socket.send(encodeHello(feed, complete()));
    };
    socket.onmessage = ({ data }: MessageEvent<unknown>) => {
      const record = data instanceof ArrayBuffer ? decode(data) : null;
      if (record?.type === "alert") this.onAlert(record);
      else if (record?.type === "welcome" && record.feed !== feed) this.end();
    };
    socket.onclose = () => {
      this.timer = setTimeout(() => {
        this.follow(feed, complete);
      }, RETRY_MS);
    };
  }

  end(): void {
    clearTimeout(this.timer);
    if (this.socket === null) return;
    this.socket.onopen = this.socket.onmessage = this.socket.onclose = null;
    this.socket.close();
    this.socket = null;
  }
}
