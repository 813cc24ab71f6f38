// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { decode } from "../src/wire/decode";
import { Link, type LinkState } from "../src/link";
import type { DiveRecord } from "../src/wire/records";
import { FakeSocket, welcome } from "./fake_socket";
import { golden } from "./golden";

function start() {
  const sockets: FakeSocket[] = [];
  const records: DiveRecord[] = [];
  const states: LinkState[] = [];
  let feeds = 0;
  const link = new Link(
    "ws://device/feed",
    {
      record: (record) => records.push(record),
      newFeed: () => ++feeds,
      state: (state) => states.push(state),
    },
    () => {
      sockets.push(new FakeSocket());
      return sockets.at(-1) as unknown as WebSocket;
    },
  );
  link.connect();
  const socket = () => {
    const newest = sockets.at(-1);
    if (newest === undefined) throw new Error("no socket");
    return newest;
  };
  const receive = (data: unknown) => socket().onmessage?.({ data });
  return { link, sockets, socket, records, states, receive, feeds: () => feeds };
}

describe("Link", () => {
  beforeEach(() => vi.useFakeTimers());
  afterEach(() => vi.useRealTimers());

  it("says hello knowing nothing, is live once welcomed and hands the records on", () => {
    const { socket, records, states, receive, feeds } = start();
    socket().onopen?.();
    const hello = new DataView(socket().sent[0] ?? new ArrayBuffer(0));
    expect([hello.getBigUint64(16, true), hello.getBigUint64(24, true)]).toEqual([0n, 0n]);
    receive(golden("welcome"));
    receive(golden("pose"));
    expect(states).toEqual(["connecting", "live"]);
    expect(feeds()).toBe(1);
    expect(records.map((record) => record.type)).toEqual(["pose"]);
  });

  it("resumes with the feed and the sequence up to which it has everything", () => {
    const { socket, receive, feeds } = start();
    receive(golden("welcome"));
    receive(golden("caught_up"));
    socket().onclose?.();
    vi.advanceTimersByTime(500);
    socket().onopen?.();
    expect(socket().sent).toEqual([golden("hello")]);
    receive(golden("welcome"));
    expect(feeds()).toBe(1);
  });

  it("forgets the sequence when the server is another run", () => {
    const { socket, receive, feeds } = start();
    receive(golden("welcome"));
    receive(golden("caught_up"));
    receive(welcome(5n));
    expect(feeds()).toBe(2);
    socket().onclose?.();
    vi.advanceTimersByTime(500);
    socket().onopen?.();
    const hello = new DataView(socket().sent[0] ?? new ArrayBuffer(0));
    expect([hello.getBigUint64(16, true), hello.getBigUint64(24, true)]).toEqual([5n, 0n]);
  });

  it("waits longer after each failure, at most five seconds, and tries at once when hurried", () => {
    const { link, sockets, socket } = start();
    const gaps = Array.from({ length: 6 }, () => {
      const before = sockets.length;
      let waited = 0;
      socket().onclose?.();
      while (sockets.length === before) {
        vi.advanceTimersByTime(100);
        waited += 100;
      }
      return waited;
    });
    expect(gaps).toEqual([500, 1000, 2000, 4000, 5000, 5000]);
    socket().onclose?.();
    link.hurry();
    expect(sockets.length).toBe(8);
    vi.advanceTimersByTime(9000);
    expect(sockets.length).toBe(8);
  });

  it("counts what it does not understand and goes on", () => {
    const { link, records, receive } = start();
    for (const garbage of ["text", new ArrayBuffer(0), new ArrayBuffer(3), new Uint8Array(100).fill(255).buffer]) {
      receive(garbage);
    }
    receive(golden("state"));
    expect(link.ignored).toBe(4);
    expect(records.length).toBe(1);
  });

  it("gives up a connection on which it hears nothing, unless the dive is over", () => {
    const { link, sockets, receive, states } = start();
    receive(golden("welcome"));
    vi.advanceTimersByTime(9_000);
    receive(golden("statistics"));
    vi.advanceTimersByTime(9_000);
    expect(states.at(-1)).toBe("live");
    vi.advanceTimersByTime(1_000);
    expect(states.at(-1)).toBe("lost");
    expect(sockets[0]?.isClosed).toBe(true);
    vi.advanceTimersByTime(500);
    expect(sockets.length).toBe(2);
    receive(golden("welcome"));
    link.mayBeSilent = true;
    vi.advanceTimersByTime(60_000);
    expect(sockets.length).toBe(2);
    expect(states.at(-1)).toBe("live");
  });

  it("tries again when a server accepts and never answers", () => {
    const { sockets, socket } = start();
    socket().onopen?.();
    vi.advanceTimersByTime(10_500);
    expect(sockets.length).toBe(2);
  });

  it("calls news what came to be after it joined, however much it has still to be brought", () => {
    const { link, receive } = start();
    receive(golden("welcome"));
    expect(link.isCurrent).toBe(false);
    const welcome = decode(golden("welcome"));
    const newest = welcome?.type === "welcome" ? welcome.newest : NaN;
    expect(link.isNews(newest)).toBe(false);
    expect(link.isNews(newest + 1)).toBe(true);
    receive(golden("caught_up"));
    expect(link.isCurrent).toBe(true);
  });
});
