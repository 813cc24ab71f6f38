// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { decode } from "./wire/decode";
import { encodeHello } from "./wire/hello";
import type { DiveRecord, Welcome } from "./wire/records";

export type LinkState = "connecting" | "live" | "lost";

export interface LinkEvents {
  record(record: DiveRecord): void;
  /** The server is another run of itself: everything known is void. */
  newFeed(): void;
  state(state: LinkState): void;
  /** The link is live. */
  welcome?(welcome: Welcome): void;
  /** All there was has been sent, but for so many records that the server let go. */
  caughtUp?(letGo: number): void;
}

const FIRST_RETRY_MS = 500;
const LAST_RETRY_MS = 5000;
/** An idle server repeats its caught-up record every three seconds; a connection cut in silence is found out by this. */
const SILENCE_MS = 10_000;

/** Keeps one connection to the server, come what may, and resumes where the last one broke off. */
export class Link {
  /** This connection has brought all the server had when it began; what comes now is news. */
  isCurrent = false;
  /** The dive is over: silence means nothing. */
  mayBeSilent = false;
  /** Messages that were no record of ours. */
  ignored = 0;
  /** Everything of the feed up to this sequence is here. */
  complete = 0n;
  private feed = 0n;
  /** What this page has not seen was there before it up to this sequence. */
  private old = 0;
  private socket: WebSocket | null = null;
  private retryMs = FIRST_RETRY_MS;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private watchdog: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly address: string,
    private readonly events: LinkEvents,
    private readonly open: (address: string) => WebSocket = (to) => new WebSocket(to),
  ) {}

  connect(): void {
    clearTimeout(this.timer);
    this.isCurrent = false;
    this.events.state("connecting");
    const socket = this.open(this.address);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      socket.send(encodeHello(this.feed, this.complete));
    };
    socket.onmessage = (message: MessageEvent<unknown>) => {
      this.receive(message.data);
    };
    socket.onclose = () => {
      this.retryLater();
    };
    this.feedWatchdog();
  }

  /** Whether a record came to be while this page was there, or but for a broken link. */
  isNews(sequence: number): boolean {
    return sequence > this.old;
  }

  /** Tries at once when a retry is due later: the network or the viewer is back. */
  hurry(): void {
    if (this.socket === null) this.connect();
  }

  private feedWatchdog(): void {
    clearTimeout(this.watchdog);
    this.watchdog = setTimeout(() => {
      if (this.mayBeSilent) return;
      this.socket?.close();
      this.retryLater();
    }, SILENCE_MS);
  }

  private retryLater(): void {
    clearTimeout(this.watchdog);
    if (this.socket !== null) this.socket.onopen = this.socket.onmessage = this.socket.onclose = null;
    this.socket = null;
    this.events.state("lost");
    this.timer = setTimeout(() => {
      this.connect();
    }, this.retryMs);
    this.retryMs = Math.min(2 * this.retryMs, LAST_RETRY_MS);
  }

  private receive(data: unknown): void {
    this.feedWatchdog();
    const record = data instanceof ArrayBuffer ? decode(data) : null;
    if (record === null) {
      ++this.ignored;
      return;
    }
    if (record.type === "welcome") {
      this.greet(record);
    } else if (record.type === "caught_up") {
      this.complete = record.upTo;
      this.isCurrent = true;
      this.events.caughtUp?.(record.evicted);
    } else {
      this.events.record(record);
    }
  }

  private greet(welcome: Welcome): void {
    const { feed, newest } = welcome;
    if (feed !== this.feed) {
      this.feed = feed;
      this.complete = 0n;
      this.old = newest;
      this.events.newFeed();
    }
    this.retryMs = FIRST_RETRY_MS;
    this.events.state("live");
    this.events.welcome?.(welcome);
  }
}
