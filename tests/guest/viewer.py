# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""A client of nadir's page and feed. viewer.py ADDRESS:PORT SECONDS: listens as the page does, to the feed and to alerts once more,
and prints "TYPE KEY SECONDS" of each record that is newer than its connections, perhaps twice: the key is what follows
its header, the time CLOCK_MONOTONIC's when it came."""
import base64
import hashlib
import os
import socket
import struct
import sys
import threading
import time

ACCEPT = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"  # RFC 6455, 1.3
BINARY, CLOSE, PING, PONG, LAST = 2, 8, 9, 10, 0x80
# Of nadir's records: include/nadir/wire.
VERSION, HEADER = 2, 16
HELLO, WELCOME, ALERT, PLANE_COLOUR, MOSAIC_TILE, CHECK = 1, 2, 4, 9, 11, 15


class Client:
    """A GET; address: the device's own, it answers to no other name. port: where it is reached, if elsewhere."""

    def __init__(self, address, target, *fields, timeout, port=None):
        host, own_port = address.split(":")
        self.socket = socket.create_connection(("127.0.0.1", port) if port else (host, int(own_port)), timeout)
        self.socket.sendall("\r\n".join((f"GET {target} HTTP/1.1", f"Host: {address}", *fields, "", "")).encode())
        self.stream = self.socket.makefile("rb")
        self.status = int(self.stream.readline().split()[1])
        self.fields = {}
        while line := self.stream.readline().strip():
            name, value = line.split(b":", 1)
            self.fields[name.lower()] = value.strip()


class Viewer(Client):
    """Has said hello to the feed, or to records of one type of it."""

    def __init__(self, address, target="/feed", **how):
        key = base64.b64encode(os.urandom(16))
        super().__init__(address, target, f"Origin: http://{address}", "Upgrade: websocket", "Connection: Upgrade",
                         f"Sec-WebSocket-Key: {key.decode()}", "Sec-WebSocket-Version: 13", **how)
        proof = base64.b64encode(hashlib.sha1(key + ACCEPT).digest())
        if self.status != 101 or self.fields.get(b"sec-websocket-accept") != proof:
            raise OSError(f"no WebSocket: {self.status} {self.fields}")
        self.send(BINARY, struct.pack("<BBHIQQQ", HELLO, VERSION, 0, 0, 0, 0, 0))

    def send(self, kind, message):
        """One masked frame; the mask is 0."""
        self.socket.sendall(bytes([LAST | kind, 0x80 | len(message)]) + bytes(4) + message)

    def record(self):
        """The next record, of however many frames."""
        record = b""
        while True:
            kind, length = self.stream.read(2)
            if length == 126:
                [length] = struct.unpack(">H", self.stream.read(2))
            elif length == 127:
                [length] = struct.unpack(">Q", self.stream.read(8))
            body = self.stream.read(length)
            if kind == LAST | CLOSE:
                raise OSError(f"closed: {body[2:].decode()}")
            if kind == LAST | PING:
                self.send(PONG, body)
                continue
            record += body
            if kind & LAST:
                return record


def listen(address, target, give_up):
    viewer = Viewer(address, target, timeout=10)
    [old] = struct.unpack_from("<Q", viewer.record(), HEADER + 8)  # of the welcome: the newest there was
    while time.monotonic() < give_up:
        record = viewer.record()
        if len(record) >= HEADER + 8:
            sequence, key = struct.unpack_from("<QQ", record, HEADER - 8)
            if sequence > old:
                print(f"{record[0]} {key} {time.monotonic():.3f}\n", end="")


def main(address, seconds):
    give_up = time.monotonic() + float(seconds)
    threading.Thread(target=listen, args=(address, f"/records?type={ALERT}", give_up), daemon=True).start()  # silent for long, maybe
    listen(address, "/feed", give_up)


if __name__ == "__main__":
    main(*sys.argv[1:])
