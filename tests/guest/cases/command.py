# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""A tablet ends the dive and begins another with the device's token, puts a mark, asks for a sub-map and shuts the board down."""
import http.client
import json
import subprocess

from cases.page import ADDRESS
from machine import SLOWEST, Failed

ENDED_S = 10  # with its files
POWER_OFF_S = 60


def call(guest, method, path, token=None, **body):
    """The status and the answer."""
    connection = http.client.HTTPConnection("127.0.0.1", guest.page, timeout=30)
    connection.putrequest(method, f"/api/{path}", skip_host=True, skip_accept_encoding=True)
    fields = {"Host": ADDRESS, "Nadir-Session": "session-of-the-test", "Nadir-Name": "tablet"}
    if token:
        fields["Authorization"] = f"Bearer {token}"
    content = json.dumps(body).encode() if body else b""
    if method == "POST":
        fields["Content-Length"] = str(len(content))
    for name, value in fields.items():
        connection.putheader(name, value)
    connection.endheaders(content)
    answer = connection.getresponse()
    return answer.status, json.loads(answer.read())


def command(guest, token, method, path, **body):
    deadline = guest.clock() + ENDED_S
    while True:
        status, answer = call(guest, method, path, token, **body)
        if status != 409 or guest.clock() > deadline:  # the command before is being done
            break
    if status not in (200, 202):
        raise Failed(f"{method} {path}: {status} {answer}")
    return answer


def ended(guest, dive):
    """Seconds until the dive's files are made."""
    begun = guest.clock()
    guest.command(f"until test -e /var/lib/nadir/dives/{dive}/dive.json; do sleep 0.05; done", limit_s=ENDED_S)
    return guest.clock() - begun


def run(guest, nadir):
    first = nadir.mapping()
    status, _ = call(guest, "POST", "dive/stop", "not-the-token")
    if status != 401:
        raise Failed(f"a wrong token is answered {status}")
    token = guest.command("nadir token").out.split()[0]
    process = nadir.process()
    command(guest, token, "POST", "control/take")
    command(guest, token, "POST", "dive/stop")
    took = ended(guest, first)
    known = nadir.dives()
    command(guest, token, "POST", "dive/start")
    second = nadir.mapped(known)[1]
    command(guest, token, "POST", "marks", x=0.1, y=0.2, z=-1, note="a mark")
    nadir.listen()
    since = guest.clock()
    command(guest, token, "POST", "dive/submap")
    nadir.expect("sub-map 1 starts", since, 15)
    if nadir.process() != process:
        raise Failed("nadir started again between the dives")
    [recorded] = [dive for dive in call(guest, "GET", "dives")[1] if dive["recording"]]
    if recorded["name"] != second:
        raise Failed(f"recorded is {recorded}, not {second}")
    command(guest, token, "POST", "shutdown")
    try:
        guest.qemu.wait(POWER_OFF_S * SLOWEST)
    except subprocess.TimeoutExpired:
        raise Failed(f"the board is on still\n{nadir.log()}") from None
    guest.power_cut()  # of what is left: the disk's server, with what was not flushed
    guest.boot()
    nadir.booted()
    marks = guest.command(f"cat /var/lib/nadir/dives/{second}/marks.jsonl; test -e /var/lib/nadir/dives/{second}/dive.json").out
    if "a mark" not in marks:
        raise Failed(f"the mark is not in the dive: {marks}")
    return f"the dive ended with its files after {took:.2f} s; the next in the same process; both whole after the board shut itself down"
