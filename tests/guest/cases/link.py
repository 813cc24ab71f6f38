# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""A viewer behind 1 Mbit/s, 5 % loss and 200 ms there and back: it sees a plane within two seconds, an alert within half of one."""
import math

from machine import Failed
from viewer import ALERT, PLANE_COLOUR

HERE, THERE = "10.213.7.1", "10.213.7.2"
LINK = "netem delay 100ms loss 5% rate 1mbit"  # each way
WATCHED_S = 11
PLANE_S, ALERT_S = 2, 0.5


def run(guest, nadir):
    nadir.mapping()
    try:
        guest.command("ip netns add far && ip link add near0 type veth peer name far0 netns far && "
                      f"ip address add {HERE}/30 dev near0 && ip link set near0 up && "
                      f"ip -n far address add {THERE}/30 dev far0 && ip -n far link set far0 up && "
                      f"tc qdisc add dev near0 root {LINK} && ip netns exec far tc qdisc add dev far0 root {LINK}")
        near = watch(guest, "near", "127.0.0.1")
        far = watch(guest, "far", HERE, "ip netns exec far ")
        # Mapping costs the emulated processor most. The images stop, go on and stop: alerts.
        guest.command("stop() { systemctl kill -s STOP feed; }; sleep 4; stop; sleep 2; systemctl kill -s CONT feed; sleep 1; stop")
        control = guest.command(f"ss -tinH dst {THERE}").out.split()
        came = [told(guest, name) for name in (near, far)]
    finally:
        nadir.stop_feed()
        guest.command("ip link delete near0; ip netns delete far", check=False)
        # Longer than the others' dives, its files would keep the emulated processor busy for minutes.
        guest.command("systemctl kill -s KILL nadir.service; systemctl stop nadir.service; rm -rf /var/lib/nadir/dives/dive-*", check=False, limit_s=90)
    planes, alerts = (delays(*came, kind) for kind in (PLANE_COLOUR, ALERT))
    words = f"{len(planes)} planes after {said(planes)}, {len(alerts)} alerts after {said(alerts)}"
    if "bbr" not in control:
        raise Failed(f"not by BBR: {' '.join(control)}; {words}")
    if len(planes) < 3 or len(alerts) < 10:
        raise Failed(f"too little to judge by: {words}")
    if planes[-1] > PLANE_S or alerts[-1] > ALERT_S:
        raise Failed(f"{words}; {PLANE_S} s are allowed, {ALERT_S} for alerts")
    return words


def watch(guest, name, address, where=""):
    guest.command(f"systemd-run -q --unit={name} -p StandardOutput=file:/run/{name} {where}python3 /host/guest/viewer.py {address}:8765 {WATCHED_S}")
    return name


def told(guest, name):
    """{(type, key): when it came first}."""
    guest.command(f"while systemctl -q is-active {name}; do sleep 0.5; done", limit_s=WATCHED_S + 20)
    came = {}
    for kind, key, at in map(str.split, guest.command(f"cat /run/{name}; rm /run/{name}").out.splitlines()):
        record = (int(kind), int(key))
        came[record] = min(float(at), came.get(record, math.inf))
    if not came:
        raise Failed(f"{name} was told nothing\n{guest.command(f'journalctl -b -u {name} --no-pager', check=False).out}")
    return came


def delays(near, far, kind):
    """How much later the far viewer was told what came to be while both were there and listened long enough; ascending."""
    begin, end = min(far.values()), max(near.values()) - PLANE_S
    return sorted(far.get(record, math.inf) - at for record, at in near.items() if record[0] == kind and begin < at < end)


def said(delays):
    return f"{', '.join(f'{delay:.2f}' for delay in delays)} s"
