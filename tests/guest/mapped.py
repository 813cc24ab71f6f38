# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""mapped.py SECONDS [DIVE...]: waits for the first image on the map of a dive other than these; prints when, and the dive."""
import pathlib
import sys
import time

DIVES = pathlib.Path("/var/lib/nadir/dives")


def main(seconds, *known):
    give_up = time.monotonic() + float(seconds)
    while time.monotonic() < give_up:
        for dive in DIVES.glob("dive-*"):
            if dive.name not in known and next(dive.glob("projected/[!.]*.png"), None):
                print(f"{time.monotonic():.3f} {dive.name}")
                return
        time.sleep(0.05)
    sys.exit("nothing is mapped")


main(*sys.argv[1:])
