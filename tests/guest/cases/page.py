# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""The page reaches a client on another machine, by HTTP and as a WebSocket that talks."""
import base64
import hashlib
import os
import socket
import urllib.request

from machine import Failed

LIMIT_S = 120  # of the host
ACCEPT = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"  # RFC 6455, 1.3


def run(guest, nadir):
    nadir.install()
    guest.command("systemctl is-active nadir.socket")
    address = f"127.0.0.1:{guest.page}"
    with urllib.request.urlopen(f"http://{address}/", timeout=LIMIT_S) as answer:
        page = answer.read()
        if answer.status != 200 or b"<html" not in page.lower():
            raise Failed(f"/ answers {answer.status} with {page[:80]}")
    key = base64.b64encode(os.urandom(16))
    with socket.create_connection(("127.0.0.1", guest.page), LIMIT_S) as client:
        client.sendall(f"GET /live HTTP/1.1\r\nHost: {address}\r\nOrigin: http://{address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                       f"Sec-WebSocket-Key: {key.decode()}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
        stream = client.makefile("rb")
        head = [stream.readline().strip()]
        while head[-1]:
            head.append(stream.readline().strip())
        proof = base64.b64encode(hashlib.sha1(key + ACCEPT).digest())
        if b" 101 " not in head[0] + b" " or not any(line.lower().startswith(b"sec-websocket-accept") and proof in line for line in head):
            raise Failed(f"no WebSocket: {head}")
        if not stream.read(2):
            raise Failed("the WebSocket was closed without a word")
    return f"{len(page)} bytes, WebSocket open"
