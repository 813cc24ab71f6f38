# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""The package installs, its service is ready soon after its start and maps soon after the camera's first images."""
from machine import Failed

READY_S, MAPPED_S = 5, 10


def run(guest, nadir):
    nadir.use_pair()
    for unit in ("nadir.service", "nadir.socket"):
        guest.command(f"systemctl is-enabled {unit} && systemctl is-active {unit}")
    if nadir.show("Type")["Type"] != "notify":
        raise Failed("nadir.service does not tell when it is ready")
    nadir.restart()
    ready = nadir.ready_after()
    known = nadir.dives()
    first = nadir.feed()
    mapped = nadir.mapped(known)[0] - first
    if ready > READY_S or mapped > MAPPED_S:
        raise Failed(f"ready after {ready:.2f} s, {READY_S} are allowed; mapped after {mapped:.2f} s, {MAPPED_S} are allowed")
    return f"ready {ready:.2f} s after its start, first image mapped {mapped:.2f} s after the camera's first"
