# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""What the cases know of nadir: how it is installed and set, its cameras, its journal, its dives."""
import json
import re
import shlex

from machine import Failed

FEED_HZ = 3
VIVID_HZ = 5
VIVID_SIZE = 320, 180
VIMC_SIZE = 480, 360


class Product:
    """nadir in a guest; what a case needs is set up when it is first asked for."""

    def __init__(self, guest, package):
        self.guest = guest
        self.package = package
        self.installed = False
        self.pair_set = False
        self.messages = None

    def booted(self):
        """The guest has been booted again."""
        self.messages = None

    def install(self):
        """Installs the package. A calibration is there before, as on a prepared board."""
        if self.installed:
            return
        self.guest.command("mkdir -p /etc/nadir && cp /host/survey/calib.yml /etc/nadir/camera.yml")
        self.guest.command(f"dpkg -i /host/package/{shlex.quote(self.package)}", limit_s=60)
        self.installed = True

    def configure(self, **settings):
        """Writes capture's settings over those of /etc/nadir/nadir.toml; nadir has to be started again."""
        changes = "".join(f" -e {shlex.quote(f's#^{name} = .*#{name} = {toml(value)}#')}" for name, value in settings.items())
        self.guest.command(f"sed -i {changes} /etc/nadir/nadir.toml")

    def use_pair(self):
        """A pair of cameras through v4l2loopback; feed() makes them give images."""
        self.pair_set = True
        self.install()
        self.guest.command("modprobe v4l2loopback video_nr=40,41 card_label=left,right exclusive_caps=1,1 max_buffers=4 && udevadm settle")
        self.guest.command("cp /host/survey/calib.yml /etc/nadir/camera.yml")
        self.configure(camera="left", camera_right="right", calibration="/etc/nadir/camera.yml", scale=0.5, rate_hz=0, features=500, tie_points=150)

    def feed(self):
        """Starts the pair; returns when it gave its first images."""
        self.guest.command(f"systemd-run -q --unit=feed -p StandardOutput=file:/run/feed python3 /host/guest/feed.py /host/survey {FEED_HZ} /dev/video40 /dev/video41")
        return float(self.guest.command("until grep -qs first /run/feed; do systemctl -q is-active feed || { cat /run/feed; exit 1; }; sleep 0.05; done; "
                                        "cut -d' ' -f2 /run/feed; rm /run/feed").out)

    def stop_feed(self):
        self.guest.command("systemctl stop feed; rm -f /run/feed", check=False)

    def use_vivid(self):
        """A single camera of the kernel's virtual video driver."""
        self.pair_set = False
        self.install()
        self.guest.command("modprobe vivid n_devs=1 node_types=1 && udevadm settle")
        self.use_single("platform:vivid-000", VIVID_SIZE, rate_hz=VIVID_HZ)

    def use_vimc(self):
        """A single camera of libcamera: the kernel's virtual media controller. rmmod vimc ends it."""
        self.pair_set = False
        self.install()
        plugin = self.package.replace("nadir_", "nadir-libcamera*_", 1)
        self.guest.command(f"dpkg -i /host/package/{plugin}", limit_s=60)
        self.guest.command("modprobe vimc && udevadm settle")
        self.use_single("libcamera:auto", VIMC_SIZE, rate_hz=FEED_HZ)

    def use_single(self, camera, size, rate_hz):
        """Sets nadir to one camera, with a calibration of that size."""
        width, height = size
        calibration = (f"%YAML:1.0\n---\nimage_width: {width}\nimage_height: {height}\ncamera_matrix: !!opencv-matrix\n"
                       f"   rows: 3\n   cols: 3\n   dt: d\n   data: [ 300., 0., {width / 2}, 0., 300., {height / 2}, 0., 0., 1. ]\n"
                       "distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ 0., 0., 0., 0., 0. ]\n")
        self.guest.command(f"printf %s {shlex.quote(calibration)} >/etc/nadir/single.yml")
        self.configure(camera=camera, camera_right="", calibration="/etc/nadir/single.yml", scale=1.0, rate_hz=rate_hz)

    def take_vivid(self):
        """Has the service take that camera's images; expect() sees what it says."""
        self.stop_feed()
        self.use_vivid()
        self.listen()
        self.restart()
        self.expect("the dive:", self.guest.clock() - 5, 15)

    def unplug_vivid(self):
        return self.guest.command("echo vivid.0 >/sys/bus/platform/drivers/vivid/unbind").begin

    def plug_in_vivid(self):
        return self.guest.command("echo vivid.0 >/sys/bus/platform/drivers/vivid/bind").begin

    def restart(self):
        self.guest.command("systemctl restart nadir.service")

    def show(self, *properties):
        out = self.guest.command("systemctl show nadir.service -p " + ",".join(properties)).out
        return dict(line.split("=", 1) for line in out.splitlines())

    def process(self):
        return int(self.show("MainPID")["MainPID"])

    def ready_after(self):
        """From the start of the process to its READY=1, in seconds."""
        times = self.show("ActiveState", "ExecMainStartTimestampMonotonic", "ActiveEnterTimestampMonotonic")
        if times["ActiveState"] != "active":
            raise Failed(f"nadir.service is {times['ActiveState']}\n{self.log()}")
        return (int(times["ActiveEnterTimestampMonotonic"]) - int(times["ExecMainStartTimestampMonotonic"])) * 1e-6

    def dives(self):
        return self.guest.command("ls /var/lib/nadir/dives").out.split()

    def mapped(self, known, limit_s=30):
        """When the first image came onto the map of a dive that is not among the known, and the dive's name."""
        result = self.guest.python("mapped.py", limit_s, *known, check=False, limit_s=limit_s + 10)
        if result.status != 0:
            raise Failed(f"{result.out}\n{self.log()}")
        at, dive = result.out.split()
        return float(at), dive

    def mapping(self):
        """Has the service map what the pair sees, if it does not already; returns the dive."""
        if self.pair_set and self.guest.command("systemctl -q is-active feed nadir", check=False).status == 0:
            newest = self.dives()[-1:]
            if newest and self.guest.command(f"test -e /var/lib/nadir/dives/{newest[0]}/dive.json", check=False).status != 0:
                return self.mapped(set(self.dives()) - set(newest))[1]
        self.stop_feed()
        # Once used, v4l2loopback may refuse a writer's format.
        self.guest.command("systemctl stop nadir.service; modprobe -r v4l2loopback", check=False, limit_s=90)
        self.use_pair()
        known = self.dives()
        self.feed()
        self.restart()
        return self.mapped(known)[1]

    def log(self):
        return self.guest.command("journalctl -b -u nadir -n 30 -o short-monotonic --no-pager", check=False).out

    def listen(self):
        """From now on expect() sees what nadir says."""
        if self.messages is None:
            self.messages = self.guest.follow("journalctl", "-f", "-n", "0", "-o", "json", "--output-fields=MESSAGE", "-u", "nadir")

    def expect(self, pattern, since, limit_s):
        """When nadir said something like it, in seconds after `since`; a failure if it was later than the limit."""
        def at(line):
            entry = json.loads(line.text)
            return int(entry["__MONOTONIC_TIMESTAMP"]) * 1e-6, str(entry.get("MESSAGE", ""))

        seen = 0
        while True:
            for line in self.messages.lines[seen:]:
                seen += 1
                when, message = at(line)
                if when >= since and re.search(pattern, message):
                    if when - since > limit_s:
                        raise Failed(f"'{message}' came after {when - since:.2f} s, {limit_s} are allowed")
                    return when - since
            if self.messages.read(host_limit_s=5) is None and self.guest.clock() > since + limit_s + 3:
                raise Failed(f"no '{pattern}' within {limit_s} s\n{self.log()}")


def toml(value):
    return f"'{value}'" if isinstance(value, str) else value
