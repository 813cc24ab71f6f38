# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""Any one thread of nadir hangs: it starts again and maps a new dive soon after."""
from machine import Failed

STAGES = ("capture", "odometry", "plane", "mosaic2d", "projection3d", "revisit", "record", "page", "nadir")
MAPPED_S = 10


def run(guest, nadir):
    nadir.mapping()
    took = {}
    for stage in STAGES:
        known = nadir.dives()
        guest.command(f"systemd-run -q --unit=hang -p StandardOutput=file:/run/hang python3 /host/guest/stop_thread.py {nadir.process()} {stage}")
        stopped = float(guest.command("until grep -qs stopped /run/hang; do systemctl -q is-active hang || { journalctl -u hang -n 5; exit 1; }; sleep 0.05; done; "
                                      "cut -d' ' -f2 /run/hang; rm /run/hang").out)
        took[stage] = nadir.mapped(known)[0] - stopped
        if took[stage] > MAPPED_S:
            raise Failed(f"{stage} hung: mapping again after {took[stage]:.2f} s, {MAPPED_S} are allowed\n{nadir.log()}")
    return "mapping again after " + ", ".join(f"{stage} {seconds:.1f} s" for stage, seconds in took.items())
