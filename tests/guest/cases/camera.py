# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""The camera goes and comes back, again and again: told within a second, back within three."""
from machine import Failed

TIMES = 20
LOST_S, BACK_S = 1, 3


def run(guest, nadir):
    nadir.take_vivid()
    before = footprint(guest, nadir)
    lost, back = [], []
    for _ in range(TIMES):
        lost.append(nadir.expect("^camera_lost", nadir.unplug_vivid(), LOST_S))
        back.append(nadir.expect("^camera_back", nadir.plug_in_vivid(), BACK_S))
    after = footprint(guest, nadir)
    if after > before:
        raise Failed(f"{before} open files before, {after} after")
    return f"{TIMES} times: told within {max(lost):.2f} s, back within {max(back):.2f} s; {after} open files as before"


def footprint(guest, nadir):
    return int(guest.command(f"ls /proc/{nadir.process()}/fd | wc -l").out)
