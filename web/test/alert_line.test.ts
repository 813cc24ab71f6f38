// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it, vi } from "vitest";
import { AlertLine } from "../src/alert_line";
import { decode } from "../src/wire/decode";
import { FakeSocket, welcome } from "./fake_socket";
import { golden } from "./golden";

function start(feed = 7n) {
  let complete = 40n;
  const sockets: FakeSocket[] = [];
  const told: number[] = [];
  const line = new AlertLine(
    "ws://device/records?type=4",
    ({ id }) => told.push(id),
    () => {
      sockets.push(new FakeSocket());
      return sockets.at(-1) as unknown as WebSocket;
    },
  );
  line.follow(feed, () => complete);
  const receive = (data: unknown, socket = sockets.at(-1)) => socket?.onmessage?.({ data });
  const helloOf = (socket = sockets.at(-1)) => {
    socket?.onopen?.();
    const hello = new DataView(socket?.sent[0] ?? new ArrayBuffer(0));
    return [hello.getBigUint64(16, true), hello.getBigUint64(24, true)];
  };
  return { line, sockets, told, receive, helloOf, setComplete: (sequence: bigint) => (complete = sequence) };
}

describe("AlertLine", () => {
  it("asks for what the link has still to bring, and hands on alerts alone", () => {
    const { told, receive, helloOf } = start();
    expect(helloOf()).toEqual([7n, 40n]);
    for (const data of [welcome(7n), golden("alert"), golden("caught_up"), golden("pose"), "text", new ArrayBuffer(3)]) receive(data);
    const alert = decode(golden("alert"));
    expect(told).toEqual([alert?.type === "alert" ? alert.id : "no alert"]);
  });

  it("says nothing of another feed than the link's", () => {
    const { sockets, told, receive } = start(7n);
    receive(welcome(8n));
    receive(golden("alert"));
    expect(told).toEqual([]);
    expect(sockets[0]?.isClosed).toBe(true);
  });

  it("is opened anew when it breaks while the link goes on", () => {
    vi.useFakeTimers();
    const { line, sockets, helloOf, setComplete } = start();
    setComplete(50n);
    sockets[0]?.onclose?.();
    vi.advanceTimersByTime(6000);
    expect(sockets.length).toBe(2);
    expect(helloOf()).toEqual([7n, 50n]);
    sockets[1]?.onclose?.();
    line.end();
    vi.advanceTimersByTime(6000);
    expect(sockets.length).toBe(2);
    vi.useRealTimers();
  });

  it("is one at a time, and none once the link is lost", () => {
    const { line, sockets, told, receive } = start();
    line.follow(9n, () => 0n);
    expect(sockets.map(({ isClosed }) => isClosed)).toEqual([true, false]);
    receive(golden("alert"), sockets[0]);
    line.end();
    line.end();
    receive(golden("alert"));
    expect(told).toEqual([]);
    expect(sockets.map(({ isClosed }) => isClosed)).toEqual([true, true]);
  });
});
