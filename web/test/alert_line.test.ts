// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from "vitest";
import { AlertLine } from "../src/alert_line";
import { decode } from "../src/wire/decode";
import { FakeSocket, welcome } from "./fake_socket";
import { golden } from "./golden";

function start(feed = 7n) {
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
  line.follow({ type: "welcome", feed, newest: 40 });
  const receive = (data: unknown, socket = sockets.at(-1)) => socket?.onmessage?.({ data });
  return { line, sockets, told, receive };
}

describe("AlertLine", () => {
  it("asks for what came to be since the welcome, and hands on alerts alone", () => {
    const { sockets, told, receive } = start();
    sockets[0]?.onopen?.();
    const hello = new DataView(sockets[0]?.sent[0] ?? new ArrayBuffer(0));
    expect([hello.getBigUint64(16, true), hello.getBigUint64(24, true)]).toEqual([7n, 40n]);
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

  it("is one at a time, and none once the link is lost", () => {
    const { line, sockets, told, receive } = start();
    line.follow({ type: "welcome", feed: 9n, newest: 0 });
    expect(sockets.map(({ isClosed }) => isClosed)).toEqual([true, false]);
    receive(golden("alert"), sockets[0]);
    line.end();
    line.end();
    receive(golden("alert"));
    expect(told).toEqual([]);
    expect(sockets.map(({ isClosed }) => isClosed)).toEqual([true, true]);
  });
});
