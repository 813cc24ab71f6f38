# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""feed.py SURVEY HZ NODE [NODE]: plays a survey's JPEG images, forwards and backwards for ever, into v4l2loopback devices.

Prints the time of the first images."""
import fcntl
import glob
import itertools
import os
import struct
import sys
import time

VIDIOC_S_FMT = 0xC0D05605
OUTPUT, FIELD_NONE = 2, 1


def size_of(jpeg):
    """Width and height, of the frame header."""
    at = 2
    while jpeg[at + 1] not in (0xC0, 0xC1, 0xC2):
        at += 2 + int.from_bytes(jpeg[at + 2:at + 4], "big")
    height, width = struct.unpack(">HH", jpeg[at + 5:at + 9])
    return width, height


def camera(node, jpeg):
    width, height = size_of(jpeg)
    device = os.open(node, os.O_RDWR)
    pixels = struct.pack("6I", width, height, int.from_bytes(b"MJPG", "little"), FIELD_NONE, 0, width * height)
    fcntl.ioctl(device, VIDIOC_S_FMT, bytearray(struct.pack("II", OUTPUT, 0) + pixels).ljust(208, b"\0"))
    return device


def main(survey, hz, *nodes):
    folders = [f"{survey}/images/{side}" for side in ("left", "right")]
    images = [[open(name, "rb").read() for name in sorted(glob.glob(f"{folder}/*.jpg"))] for folder in folders[:len(nodes)]]
    cameras = [camera(node, files[0]) for node, files in zip(nodes, images)]
    there = range(len(images[0]))
    due = time.monotonic()
    print(f"first {due:.3f}", flush=True)
    for number in itertools.cycle([*there, *there[-2:0:-1]]):
        for device, files in zip(cameras, images):
            os.write(device, files[number])
        due += 1 / float(hz)
        time.sleep(max(0, due - time.monotonic()))


main(*sys.argv[1:])
