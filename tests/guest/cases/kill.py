# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""Killed while it maps, nadir starts again, maps a new dive and makes the files of the earlier one."""
from dives import check_recovered, seen
from machine import Failed

MAPPED_S = 10


def run(guest, nadir):
    dive = nadir.mapping()
    guest.command("sleep 3")
    known = nadir.dives()
    before = seen(guest, dive)
    killed = guest.command("systemctl kill -s KILL nadir.service").begin
    took = nadir.mapped(known)[0] - killed
    if took > MAPPED_S:
        raise Failed(f"mapping again after {took:.2f} s, {MAPPED_S} are allowed")
    return f"mapping again after {took:.2f} s; earlier dive: {check_recovered(guest, nadir, dive, before)}"
