# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""A Debian guest under qemu's software emulation: boot, command, power cut.

Its clock counts instructions, 1 ns each on one core, and stands still while the host does something else: a board slower than
a Raspberry Pi 4, whose figures do not depend on what else runs on the host. Idle, it goes with the host's clock. All times are
its CLOCK_MONOTONIC, in seconds; only limits that end a wait in vain are the host's.
"""
import collections
import itertools
import json
import os
import pathlib
import queue
import shlex
import socket
import subprocess
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
BOOT_LIMIT_S = 600  # of the host, 25 when it is idle
COMMAND_LIMIT_S = 30  # of the guest
SLOWEST = 60  # seconds of the host for one of the guest

# The last five spare the emulated processor busy loops: calibrations whose results are known, and self-tests.
KERNEL = ("console=ttyS0 quiet loglevel=4 net.ifnames=0 mitigations=off audit=0 systemd.show_status=0 "
          "tsc=reliable tsc_early_khz=1000000 nolapic_timer nohpet cryptomgr.notests")

Result = collections.namedtuple("Result", "status out begin end")
Line = collections.namedtuple("Line", "text at")


class Failed(Exception):
    pass


class Machine:
    """One guest with its own disk, a thin layer over the image in `image`; `folder` keeps the disk and the console's log.

    shares: {name: host folder}, read-only at /host/name in the guest. page: the host's port of the guest's port 8765.
    """

    def __init__(self, image, folder, shares=None, memory_mb=2048):
        self.image = pathlib.Path(image)
        self.folder = pathlib.Path(folder)
        self.shares = {"guest": HERE, **(shares or {})}
        self.memory_mb = memory_mb
        self.page = free_port()
        self.qemu = self.server = self.port = None
        self.folder.mkdir(parents=True, exist_ok=True)
        self.disk = self.folder / "disk.qcow2"
        self.disk.unlink(missing_ok=True)
        check_call("qemu-img", "create", "-q", "-f", "qcow2", "-F", "raw", "-b", self.image / "disk.ext4", self.disk)
        os.truncate(self.disk, 8 << 30)  # it cannot grow where it is used; the host's disk is not taken up by that

    def boot(self):
        """Starts the guest; returns once its agent answers and what it has at boot has started."""
        agent, disk = self.folder / "agent", self.folder / "disk"
        agent.unlink(missing_ok=True)
        disk.unlink(missing_ok=True)
        # Holds what is written until the guest flushes it, as a disk's cache does: a power cut takes it.
        self.server = start(self.folder / "disk.log", "nbdkit", "-f", "-U", disk, "--filter=cache", "file", self.disk, "cache=writeback")
        connect(disk, self.server).close()
        self.qemu = start(self.folder / "qemu.log", *self.command_line(agent, disk))
        self.port = connect(agent, self.qemu)
        self.ids = itertools.count(1)
        self.answers = {0: queue.Queue()}
        threading.Thread(target=self.listen, args=(self.port.makefile("rb"), self.answers), daemon=True).start()
        self.answer(0, BOOT_LIMIT_S)
        self.command("ip link set lo up; ip link set eth0 up; ip address add 10.0.2.15/24 dev eth0; ip route add default via 10.0.2.2")
        for name in self.shares:
            if name != "guest":
                self.command(f"mkdir -p /host/{name} && mount -t 9p -o ro,trans=virtio,version=9p2000.L,msize=262144,cache=loose {name} /host/{name}")
        return self

    def command_line(self, agent, disk):
        yield from ("qemu-system-x86_64", "-accel", "tcg,thread=single,tb-size=512", "-icount", "shift=0,sleep=on", "-machine", "q35,smm=off,sata=off",
                    "-cpu", "max,la57=off", "-smp", 1, "-m", self.memory_mb, "-nodefaults", "-no-user-config", "-display", "none", "-no-reboot")
        yield from ("-kernel", self.image / "vmlinux", "-initrd", self.image / "initrd", "-append", KERNEL)
        yield from ("-serial", f"file:{self.folder}/console.log", "-device", "virtio-rng-pci")
        yield from ("-drive", f"if=virtio,format=qcow2,cache=writeback,file=nbd+unix:///?socket={disk}")
        yield from ("-netdev", f"user,id=net,restrict=on,hostfwd=tcp:127.0.0.1:{self.page}-:8765", "-device", "virtio-net-pci,netdev=net,romfile=")
        yield from ("-device", "virtio-serial-pci", "-chardev", f"socket,id=agent,path={agent},server=on,wait=off",
                    "-device", "virtserialport,chardev=agent,nr=1")
        for name, path in self.shares.items():
            yield from ("-virtfs", f"local,path={path},mount_tag={name},security_model=none,readonly=on")

    def listen(self, lines, answers):
        try:
            for line in lines:
                message = json.loads(line)
                answers[message["id"]].put(message)
        except ConnectionResetError:
            pass
        for waiting in list(answers.values()):
            waiting.put(None)

    def send(self, **request):
        number = next(self.ids)
        self.answers[number] = queue.Queue()
        self.port.sendall(json.dumps({"id": number, **request}).encode() + b"\n")
        return number

    def answer(self, number, limit_s):
        try:
            message = self.answers[number].get(timeout=limit_s)
        except queue.Empty:
            raise Failed(f"the guest does not answer; see {self.folder}/console.log") from None
        if message is None:
            raise Failed(f"the guest has gone; see {self.folder}/qemu.log and console.log")
        return message

    def command(self, shell, check=True, limit_s=COMMAND_LIMIT_S):
        """Runs a shell command as root; its status, output and when it began and ended. check: a status other than 0 is a failure."""
        message = self.answer(self.send(shell=shell, timeout=limit_s), limit_s * SLOWEST)
        result = Result(message["status"], message["out"], message["begin"], message["end"])
        if check and result.status != 0:
            raise Failed(f"{shell}\nexit status {result.status}\n{result.out}")
        return result

    def python(self, script, *arguments, **keywords):
        """Runs tests/guest/<script> in the guest."""
        return self.command(shlex.join(["python3", f"/host/guest/{script}", *map(str, arguments)]), **keywords)

    def follow(self, *argv):
        """Runs a command that goes on, such as journalctl -f; Follow reads what it prints."""
        return Follow(self, self.send(follow=list(argv)))

    def clock(self):
        return self.command("true").begin

    def power_cut(self):
        """What was not flushed to the disk is lost."""
        for process in (self.server, self.qemu):
            if process:
                process.kill()
                process.wait()

    def shutdown(self):
        if self.port and self.qemu.poll() is None:
            self.send(shell="systemctl poweroff", timeout=COMMAND_LIMIT_S)
            try:
                self.qemu.wait(BOOT_LIMIT_S)
            except subprocess.TimeoutExpired:
                pass
        self.power_cut()


class Follow:
    """Lines of a command that goes on, each with the time it arrived."""

    def __init__(self, machine, number):
        self.machine = machine
        self.number = number
        self.lines = []

    def read(self, host_limit_s):
        """The next line, None when there is none in that time of the host's."""
        try:
            message = self.machine.answers[self.number].get(timeout=host_limit_s)
        except queue.Empty:
            return None
        if message is None or "status" in message:
            raise Failed("the guest or what was followed there has ended")
        self.lines.append(Line(message["line"], message["at"]))
        return self.lines[-1]


def start(log, *argv):
    """A process that ends with this one."""
    with open(log, "w") as out:
        return subprocess.Popen(["setpriv", "--pdeathsig", "KILL", *map(str, argv)], stdin=subprocess.DEVNULL, stdout=out, stderr=out)


def connect(path, process):
    """A connection to the Unix socket that a process opens in a moment."""
    deadline = time.monotonic() + BOOT_LIMIT_S
    while process.poll() is None and time.monotonic() < deadline:
        port = socket.socket(socket.AF_UNIX)
        try:
            port.connect(str(path))
            return port
        except OSError:
            port.close()
            time.sleep(0.05)
    raise Failed(f"{process.args[3]} did not start; its log is in {path.parent}")


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def check_call(*argv):
    subprocess.run([str(word) for word in argv], check=True)
