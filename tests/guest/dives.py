# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""Dives that were cut off: what was seen of them must be there again."""
import json

from machine import Failed

FOLDER = "/var/lib/nadir/dives"


def seen(guest, dive):
    """Projected images that a diver could have seen in the folder."""
    return set(guest.command(f"cd {FOLDER}/{dive}/projected && ls").out.split())


def check_recovered(guest, nadir, dive, before, limit_s=60):
    """Waits until nadir has made the files of the dive, checks each, and that nothing seen before is missing."""
    guest.command(f"timeout {limit_s} sh -c 'until test -e {FOLDER}/{dive}/dive.json; do sleep 0.2; done'", check=False, limit_s=limit_s + 10)
    result = guest.python("check_dive.py", f"{FOLDER}/{dive}", check=False)
    if result.status != 0:
        raise Failed(f"{dive} is not recovered: {result.out}\n{nadir.log()}")
    found = json.loads(result.out)
    missing = {name for name in before if name.endswith(".png")} - set(found["projected"])
    if missing:
        raise Failed(f"{dive} has lost {len(missing)} of its images: {sorted(missing)[:3]}")
    return f"{found['poses']} images, {len(found['projected'])} projected, {found['points']} points"
