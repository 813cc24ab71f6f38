# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""check_dive.py DIVE: exits with 1 and says why if a file of a finished dive is missing or not whole; prints what there is."""
import json
import math
import pathlib
import struct
import sys
import zlib


def check_png(name):
    data = name.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{name}: no PNG"
    at, kind = 8, b""
    while kind != b"IEND":
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 4:at + 8 + length]
        assert struct.pack(">I", zlib.crc32(body)) == data[at + 8 + length:at + 12 + length], f"{name}: damaged"
        at += 12 + length


def numbers(line):
    values = [float(word) for word in line.split()]
    assert all(map(math.isfinite, values)), line
    return values


def check_ply(name):
    head, _, body = name.read_bytes().partition(b"end_header\n")
    assert b"element vertex" in head and b"\nformat binary" in head, f"{name}: no binary PLY"
    count = int(head.split(b"element vertex ")[1].split()[0])
    width = sum({b"float": 4, b"double": 8, b"uchar": 1, b"uint": 4, b"int": 4, b"ushort": 2, b"float32": 4, b"uint8": 1, b"uint32": 4, b"float64": 8}[line.split()[1]]
                for line in head.split(b"\n") if line.startswith(b"property"))
    assert len(body) == count * width, f"{name}: {len(body)} bytes for {count} points of {width}"
    return count


def main(dive):
    dive = pathlib.Path(dive)
    json.loads((dive / "dive.json").read_text())
    poses = [numbers(line) for line in (dive / "trajectory.tum").read_text().splitlines() if not line.startswith("#")]
    assert poses and all(len(pose) == 8 for pose in poses), "no trajectory"
    for line in (dive / "alerts.jsonl").read_text().splitlines():
        json.loads(line)
    images = sorted(dive.glob("projected/[!.]*.png")) + sorted(dive.glob("mosaic2d/*.png"))
    for name in images:
        check_png(name)
        assert len(numbers(name.with_suffix(".pgw").read_text())) == 6, f"{name}: no place"
    projected = [name.name for name in images if name.parent.name == "projected"]
    assert projected, "no projected image"
    points = check_ply(dive / "sparse.ply")
    check_ply(dive / "projection3d.ply")
    print(json.dumps({"poses": len(poses), "projected": projected, "points": points}))


try:
    main(*sys.argv[1:])
except (OSError, AssertionError, ValueError, KeyError, IndexError, struct.error) as error:
    sys.exit(f"{type(error).__name__}: {error}")
