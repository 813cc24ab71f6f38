# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""The camera goes and comes back, again and again: told within a second, back within three."""
from machine import Failed

TIMES = 20
LOST_S, BACK_S = 1, 3
DRIVER = "/sys/bus/platform/drivers/vivid"


def run(guest, nadir):
    nadir.stop_feed()
    nadir.use_vivid()
    nadir.listen()
    nadir.restart()
    nadir.expect("the dive:", guest.clock() - 5, 15)
    before = footprint(guest, nadir)
    lost, back = [], []
    for _ in range(TIMES):
        gone = guest.command(f"echo vivid.0 >{DRIVER}/unbind").begin
        lost.append(nadir.expect("^camera_lost", gone, LOST_S))
        returned = guest.command(f"echo vivid.0 >{DRIVER}/bind").begin
        back.append(nadir.expect("^camera_back", returned, BACK_S))
    after = footprint(guest, nadir)
    if after > before:
        raise Failed(f"{before} open files before, {after} after")
    return f"{TIMES} times: told within {max(lost):.2f} s, back within {max(back):.2f} s; {after} open files as before"


def footprint(guest, nadir):
    return int(guest.command(f"ls /proc/{nadir.process()}/fd | wc -l").out)
