# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs in the guest: takes commands from the virtio serial port, one JSON object a line, and answers likewise.

{"id", "shell", "timeout"}  runs it; answers {"id", "status", "out", "begin", "end"}, times in seconds of CLOCK_MONOTONIC
{"id", "follow": [argv]}    runs it and passes on each line of its output as {"id", "line", "at"}
"""
import glob
import json
import subprocess
import threading
import time

speaking = threading.Lock()


def say(port, **message):
    with speaking:
        port.write(json.dumps(message).encode() + b"\n")


def run(port, request):
    begin = time.monotonic()
    child = subprocess.Popen(["/bin/sh", "-c", request["shell"]], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, start_new_session=True)
    try:
        out, _ = child.communicate(timeout=request["timeout"])
        status = child.returncode
    except subprocess.TimeoutExpired:
        subprocess.call(["pkill", "-KILL", "-s", str(child.pid)])
        out, _ = child.communicate()
        status = "timeout"
    say(port, id=request["id"], status=status, out=out.decode(errors="replace"), begin=begin, end=time.monotonic())


def follow(port, request):
    child = subprocess.Popen(request["follow"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    for line in child.stdout:
        say(port, id=request["id"], line=line.decode(errors="replace").rstrip("\n"), at=time.monotonic())
    say(port, id=request["id"], status=child.wait())


def main():
    while not (ports := glob.glob("/dev/vport*p1")):
        time.sleep(0.05)
    with open(ports[0], "r+b", buffering=0) as port:
        say(port, id=0, status=0, out="", begin=time.monotonic(), end=time.monotonic())
        line = b""
        while True:
            line += port.readline()
            if not line.endswith(b"\n"):
                time.sleep(0.05)  # nobody listens outside
                continue
            request = json.loads(line)
            line = b""
            threading.Thread(target=follow if "follow" in request else run, args=(port, request), daemon=True).start()


main()
