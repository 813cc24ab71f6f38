# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""In the service's sandbox a program is denied all that the service does not need; without it, the same program can do it."""
import json

from machine import Failed

# The unit as it is, with the probe in nadir's place.
UNIT = r"""systemctl cat nadir.service | sed '/^\(ExecStartPre\|Restart\|RestartSec\|WatchdogSec\|StartLimit.*\|Wants=nadir\|WantedBy\|\[Install\]\)/d
s#^ExecStart=.*#ExecStart=/usr/bin/python3 -B /host/guest/probe.py\nStandardOutput=file:/run/probe\nStandardError=journal\nEnvironment=VICTIM=%d\nNotifyAccess=main#' >/run/systemd/system/probe.service"""


def run(guest, nadir):
    nadir.use_pair()
    guest.command("mkdir -p /home/diver && echo hello >/home/diver/letter && chmod -R a+rX /home/diver; touch /root/.bashrc")
    guest.command("modprobe vimc && udevadm settle")  # has a media controller
    guest.command("udevadm trigger --action=add --settle --subsystem-match=tty")  # the guest boots without
    victim = int(guest.command("systemd-run -q --unit=victim -p User=nadir sleep 1000; systemctl show -P MainPID victim").out)
    try:
        free = json.loads(guest.command(f"VICTIM={victim} python3 -B /host/guest/probe.py").out)
        guest.command(UNIT % victim)
        guest.command("systemctl daemon-reload; rm -f /run/probe; systemctl start probe; while systemctl -q is-active probe; do sleep 0.1; done")
        boxed = json.loads(guest.command("cat /run/probe || journalctl -u probe --no-pager").out)
    finally:
        guest.command("rmmod vimc; systemctl stop victim; rm -f /run/systemd/system/probe.service; systemctl daemon-reload")
    wrong = [f"{name}: allowed" for name, error in boxed["denied"].items() if not error]
    wrong += [f"{name}: not even without the sandbox: {error}" for name, error in free["denied"].items() if error]
    wrong += [f"{name}: denied: {error}" for name, error in boxed["granted"].items() if error]
    if wrong:
        raise Failed("\n".join(wrong))
    return f"{len(boxed['denied'])} things denied that work without the sandbox, {len(boxed['granted'])} granted"
