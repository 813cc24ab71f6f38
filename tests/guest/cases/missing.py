# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""Calibration, settings or the port are missing: it says so, waits, and goes on by itself."""
from machine import Failed

SOON_S = 6
HOLD_PORT = "import socket, time; s = socket.create_server(('', 8765)); time.sleep(1000)"


def run(guest, nadir):
    nadir.mapping()
    nadir.listen()
    took = {}

    guest.command("mv /etc/nadir/camera.yml /etc/nadir/away.yml")
    since = guest.command("systemctl restart nadir.service").end
    nadir.expect("^calibration_suspect: .*/etc/nadir/camera.yml", since, SOON_S)
    since = guest.command("mv /etc/nadir/away.yml /etc/nadir/camera.yml").begin
    took["calibration"] = nadir.expect("the dive:", since, SOON_S)

    guest.command("cp /etc/nadir/nadir.toml /run/right.toml && echo nonsense >>/etc/nadir/nadir.toml")
    since = guest.command("systemctl restart nadir.service").end
    nadir.expect("^storage: /etc/nadir/nadir.toml.*correct the file", since, SOON_S)
    since = guest.command("cat /run/right.toml >/etc/nadir/nadir.toml").begin
    took["settings"] = nadir.expect("the dive:", since, SOON_S)

    guest.command("systemctl stop nadir.service nadir.socket")
    guest.command(f'systemd-run -q --unit=holder python3 -c "{HOLD_PORT}"; until ss -ltn | grep -q :8765; do sleep 0.05; done')
    since = guest.command("systemctl start nadir.service; systemctl start nadir.socket", check=False).begin
    nadir.expect("port 8765: .*tried every second", since, SOON_S)
    nadir.expect("the dive:", since, SOON_S)
    since = guest.command("systemctl stop holder").begin
    guest.command("until curl -sf --compressed http://127.0.0.1:8765/ | grep -q '<html'; do sleep 0.1; done", limit_s=SOON_S)
    took["port"] = guest.clock() - since
    guest.command("systemctl stop nadir.service; systemctl start nadir.socket nadir.service")
    if nadir.show("ActiveState")["ActiveState"] != "active":
        raise Failed(nadir.log())
    return "back after " + ", ".join(f"{what} {seconds:.1f} s" for what, seconds in took.items())
