# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""The power is cut while nadir maps, and again while it recovers: the dive is made whole, and a new one is mapped after the boot."""
from dives import check_recovered, seen
from machine import Failed

MAPPED_S = 10


def run(guest, nadir):
    dive = nadir.mapping()
    guest.command("sleep 3")
    before = seen(guest, dive)
    guest.power_cut()
    guest.boot()
    guest.power_cut()
    guest.boot()
    nadir.booted()
    known = nadir.dives()
    nadir.use_pair()
    first = nadir.feed()
    took = nadir.mapped(known)[0] - first
    if took > MAPPED_S:
        raise Failed(f"mapping again after {took:.2f} s, {MAPPED_S} are allowed")
    return f"2 cuts; mapping {took:.2f} s after the camera's first images; earlier dive: {check_recovered(guest, nadir, dive, before)}"
