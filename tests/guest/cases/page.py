# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""A client on another machine gets the page by HTTP, and the growing map by its WebSocket."""
import base64
import gzip
import hashlib
import os
import socket
import struct

from machine import SLOWEST, Failed

LIMIT_S = 10  # of the guest
ADDRESS = "10.0.2.15:8765"  # the guest's own; it answers to no other name
ACCEPT = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"  # RFC 6455, 1.3
BINARY = 0x82
VERSION, HELLO, WELCOME, MOSAIC_TILE, CHECK = 2, 1, 2, 11, 15  # of nadir's records: include/nadir/wire


class Client:
    def __init__(self, port, target, *fields):
        self.socket = socket.create_connection(("127.0.0.1", port), LIMIT_S * SLOWEST)
        self.socket.sendall("\r\n".join((f"GET {target} HTTP/1.1", f"Host: {ADDRESS}", *fields, "", "")).encode())
        self.stream = self.socket.makefile("rb")
        self.status = int(self.stream.readline().split()[1])
        self.fields = {}
        while line := self.stream.readline().strip():
            name, value = line.split(b":", 1)
            self.fields[name.lower()] = value.strip()

    def send(self, message):
        """One masked frame; the mask is 0."""
        self.socket.sendall(bytes([BINARY, 0x80 | len(message)]) + bytes(4) + message)

    def message(self):
        """The next message, of one frame."""
        kind, length = self.stream.read(2)
        if length == 126:
            [length] = struct.unpack(">H", self.stream.read(2))
        elif length == 127:
            [length] = struct.unpack(">Q", self.stream.read(8))
        body = self.stream.read(length)
        return body if kind == BINARY else b"\0"


def get_page(port):
    client = Client(port, "/", "Accept-Encoding: gzip", "Connection: close")
    page = gzip.decompress(client.stream.read(int(client.fields[b"content-length"])))
    if client.status != 200 or b"<html" not in page.lower():
        raise Failed(f"/ answers {client.status} with {page[:80]}")
    return page


def findings(check):
    """{item: (verdict, found)} of a record; the worst is 2."""
    at, said = 17, {}
    for _ in range(check[16]):
        verdict, at, texts = check[at], at + 1, []
        for _ in range(3):
            [length] = struct.unpack_from("<H", check, at)
            texts.append(check[at + 2:at + 2 + length].decode())
            at += 2 + length
        said[texts[0]] = verdict, texts[1]
    return said


def watch_map(guest):
    """Seconds of the guest until a piece of the mosaic has come, and what is said of the equipment."""
    key = base64.b64encode(os.urandom(16))
    begun = guest.clock()
    client = Client(guest.page, "/feed", f"Origin: http://{ADDRESS}", "Upgrade: websocket", "Connection: Upgrade",
                    f"Sec-WebSocket-Key: {key.decode()}", "Sec-WebSocket-Version: 13")
    proof = base64.b64encode(hashlib.sha1(key + ACCEPT).digest())
    if client.status != 101 or client.fields.get(b"sec-websocket-accept") != proof:
        raise Failed(f"no WebSocket: {client.status} {client.fields}")
    client.send(struct.pack("<BBHIQQQ", HELLO, VERSION, 0, 0, 0, 0, 0))
    first = client.message()
    if first[0] != WELCOME:
        raise Failed(f"the first record is of type {first[0]}")
    took = equipment = None
    while took is None or equipment is None:
        message = client.message()
        if message[0] == MOSAIC_TILE and took is None:
            took = guest.clock() - begun
        if message[0] == CHECK and "focus" in findings(message):
            equipment = findings(message)
        if guest.clock() > begun + LIMIT_S:
            raise Failed(f"within {LIMIT_S} s no piece of the map (it took {took} s) or no word of the equipment")
    return took, equipment


def run(guest, nadir):
    nadir.mapping()
    try:
        page = get_page(guest.page)
        took, equipment = watch_map(guest)
    except (OSError, ValueError, KeyError, IndexError, struct.error) as error:
        raise Failed(f"{type(error).__name__}: {error}\n{nadir.log()}") from error
    bad = {item: found for item, (verdict, found) in equipment.items() if verdict == 2}
    if bad or "stereo calibration" not in equipment:
        raise Failed(f"the equipment: {equipment}")
    return f"{len(page)} bytes of page; a piece of the map {took:.2f} s after its call; {len(equipment)} items of equipment, none bad"
