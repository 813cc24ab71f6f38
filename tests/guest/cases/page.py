# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""A client on another machine gets the page by HTTP, and the growing map by its WebSocket."""
import gzip
import struct

from machine import SLOWEST, Failed
from viewer import CHECK, MOSAIC_TILE, WELCOME, Client, Viewer

LIMIT_S = 10  # of the guest
ADDRESS = "10.0.2.15:8765"  # the guest's own


def get_page(port):
    client = Client(ADDRESS, "/", "Accept-Encoding: gzip", "Connection: close", port=port, timeout=LIMIT_S * SLOWEST)
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
    begun = guest.clock()
    viewer = Viewer(ADDRESS, port=guest.page, timeout=LIMIT_S * SLOWEST)
    first = viewer.record()
    if first[0] != WELCOME:
        raise Failed(f"the first record is of type {first[0]}")
    took = equipment = None
    while took is None or equipment is None:
        record = viewer.record()
        if record[0] == MOSAIC_TILE and took is None:
            took = guest.clock() - begun
        if record[0] == CHECK and "focus" in findings(record):
            equipment = findings(record)
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
