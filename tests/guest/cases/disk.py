# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""The guest's disk is like a real one: a power cut takes what was written but not flushed, and nothing else."""
from machine import Failed

PREPARE = "cd /root && for name in flushed unflushed; do dd status=none if=/dev/zero of=$name bs=4096 count=64; done && sync"
WRITE = "cd /root && yes | dd status=none iflag=fullblock of={name} bs=4096 count=64 oflag=direct conv=notrunc{flush}"
IS_NEW = "head -c 2 /root/{name} | grep -q y"


def run(guest, nadir):
    guest.command(PREPARE)
    guest.command(WRITE.format(name="flushed", flush=",fsync"))
    guest.command(WRITE.format(name="unflushed", flush=""))
    guest.power_cut()
    guest.boot()
    nadir.booted()
    if guest.command(IS_NEW.format(name="flushed"), check=False).status != 0:
        raise Failed("what was flushed is lost")
    if guest.command(IS_NEW.format(name="unflushed"), check=False).status == 0:
        raise Failed("what was not flushed is there")
    return "flushed is kept, the rest lost"
