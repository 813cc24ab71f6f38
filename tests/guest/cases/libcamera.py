# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""A camera of libcamera gives images to the service in its sandbox, and they are recorded."""
import json
import re

from machine import Failed

IMAGES, LIMIT_S = 10, 60


def images(nadir):
    """How many nadir says it has mapped; its own word for those that came through."""
    found = re.match(r"mapping: (\d+) images", nadir.show("StatusText")["StatusText"])
    return int(found[1]) if found else 0


def run(guest, nadir):
    nadir.stop_feed()
    nadir.use_vimc()
    known = nadir.dives()
    try:
        nadir.restart()
        begun = guest.clock()
        while images(nadir) < IMAGES:
            if guest.command("sleep 0.2").end > begun + LIMIT_S:
                raise Failed(f"{images(nadir)} images within {LIMIT_S} s\n{nadir.log()}")
        took = guest.clock() - begun
        log = nadir.log()
    finally:
        guest.command("systemctl stop nadir.service; rmmod vimc", limit_s=90)
    [dive] = set(nadir.dives()) - set(known)
    counts = json.loads(guest.command(f"cat /var/lib/nadir/dives/{dive}/dive.json").out)["counts"]
    if counts["captured"] < IMAGES:
        raise Failed(f"recorded are {counts}\n{log}")
    return f"{IMAGES} images {took:.1f} s after the start, {counts['captured']} recorded"
