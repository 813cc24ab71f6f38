# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""Tries what a service may not do and what it must be able to do; prints what failed as JSON: {"name": "" or why not}.

Nothing that it tries leaves a trace where it is allowed. VICTIM in the environment: a process to be looked into."""
import ctypes
import fcntl
import glob
import json
import mmap
import os
import socket
import subprocess
import time

libc = ctypes.CDLL(None, use_errno=True)
SCRATCH = "/var/lib/nadir/dives/.probe"
CLONE_NEWNS, CLONE_NEWUSER, CLONE_NEWNET = 0x20000, 0x10000000, 0x40000000
PTRACE_SEIZE, PTRACE_DETACH = 0x4206, 17
PERSONALITY_NO_RANDOM = 0x0040000
PERF_SOFTWARE = 1
SYS_FINIT_MODULE, SYS_DELETE_MODULE, SYS_PERF_EVENT_OPEN = 313, 176, 298  # x86-64
VIDIOC_QUERYCAP = 0x80685600


def system(name, *arguments):
    """A function of the C library that returns -1 and errno."""
    result = getattr(libc, name)(*(ctypes.c_long(a) if isinstance(a, int) else a for a in arguments))
    if result == -1:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return result


def write_into(folder):
    name = f"{folder}/.probe"
    open(name, "w").close()
    os.remove(name)


def read(name):
    with open(name, "rb", buffering=0) as file:
        os.set_blocking(file.fileno(), False)
        file.read(1)


def in_child(function):
    """What changes the process itself."""
    child = os.fork()
    if child == 0:
        try:
            function()
            os._exit(0)
        except OSError as error:
            os._exit(error.errno)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if status != 0:
        raise OSError(status, os.strerror(status) if status > 0 else f"signal {-status}")


def mount():
    target = SCRATCH + ".mount"
    os.makedirs(target, exist_ok=True)
    try:
        system("mount", b"none", target.encode(), b"tmpfs", 0, None)
        system("umount2", target.encode(), 0)
    finally:
        os.rmdir(target)


def load_module():
    [name] = glob.glob(f"/usr/lib/modules/{os.uname().release}/kernel/drivers/net/dummy.ko")
    with open(name, "rb") as file:
        system("syscall", SYS_FINIT_MODULE, file.fileno(), b"", 0)
    system("syscall", SYS_DELETE_MODULE, b"dummy", os.O_NONBLOCK)


def look_into_process():
    victim = int(os.environ["VICTIM"])
    system("ptrace", PTRACE_SEIZE, victim, 0, 0)


def make_setuid_program():
    try:
        open(SCRATCH, "w").close()
        os.chmod(SCRATCH, 0o4755)
    finally:
        os.remove(SCRATCH)


def set_clock():
    time.clock_settime_ns(time.CLOCK_REALTIME, time.clock_gettime_ns(time.CLOCK_REALTIME))


def set_tunable():
    with open("/proc/sys/vm/swappiness", "r+") as file:
        value = file.read()
        file.seek(0)
        file.write(value)


def make_control_group():
    os.mkdir("/sys/fs/cgroup/probe")
    os.rmdir("/sys/fs/cgroup/probe")


def measure_kernel():
    attributes = (ctypes.c_char * 128)()
    attributes[0:4] = PERF_SOFTWARE.to_bytes(4, "little")
    attributes[4:8] = (128).to_bytes(4, "little")
    os.close(system("syscall", SYS_PERF_EVENT_OPEN, attributes, -1, 0, -1, 0))


def run_written_memory():
    mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC).close()


DENIED = {
    "write /etc": lambda: write_into("/etc"),
    "write /usr": lambda: write_into("/usr/lib"),
    "write /var/lib": lambda: write_into("/var/lib"),
    "write /home": lambda: write_into("/home"),
    "write /run": lambda: write_into("/run"),
    "read /home": lambda: read("/home/diver/letter"),
    "read /root": lambda: read("/root/.bashrc"),
    "read passwords": lambda: read("/etc/shadow"),
    "read the disk itself": lambda: read("/dev/vda"),
    "read memory": lambda: read("/dev/mem"),
    "write the kernel's log": lambda: os.close(os.open("/dev/kmsg", os.O_WRONLY)),
    "read the kernel's log": lambda: system("klogctl", 3, ctypes.create_string_buffer(64), 64),
    "mount": mount,
    "load a kernel module": load_module,
    "raw socket": lambda: socket.socket(socket.AF_INET, socket.SOCK_RAW, socket.IPPROTO_ICMP).close(),
    "packet socket": lambda: socket.socket(socket.AF_PACKET, socket.SOCK_RAW).close(),
    "netlink socket": lambda: socket.socket(socket.AF_NETLINK, socket.SOCK_RAW).close(),
    "look into another process": lambda: in_child(look_into_process),
    "signal another process": lambda: os.kill(1, 0),
    "see other processes": lambda: os.stat("/proc/1"),
    "make a setuid program": make_setuid_program,
    "become root": lambda: in_child(lambda: os.setresuid(0, 0, 0)),
    "new mount namespace": lambda: in_child(lambda: system("unshare", CLONE_NEWNS)),
    "new user namespace": lambda: in_child(lambda: system("unshare", CLONE_NEWUSER)),
    "new network namespace": lambda: in_child(lambda: system("unshare", CLONE_NEWNET)),
    "set the clock": set_clock,
    "set the host's name": lambda: socket.sethostname(socket.gethostname()),
    "set a kernel tunable": set_tunable,
    "make a control group": make_control_group,
    "measure the kernel": measure_kernel,
    "run memory that was written": run_written_memory,
    "change the personality": lambda: in_child(lambda: system("personality", PERSONALITY_NO_RANDOM)),
}


def camera():
    device = os.open(sorted(glob.glob("/dev/video*"))[0], os.O_RDWR)
    fcntl.ioctl(device, VIDIOC_QUERYCAP, bytearray(104))
    os.close(device)


def record():
    with open(SCRATCH, "w") as file:
        os.fsync(file.fileno())
    os.rename(SCRATCH, SCRATCH + ".whole")
    os.remove(SCRATCH + ".whole")


def serve():
    with socket.create_server(("127.0.0.1", 0)) as server, socket.create_connection(server.getsockname()):
        server.accept()[0].close()


def sensors_by_udp():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        one.bind(("127.0.0.1", 0))
        other.sendto(b"$", one.getsockname())
        one.recv(1)


def notify(text):
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.sendto(text, os.environ["NOTIFY_SOCKET"].replace("@", "\0", 1))


GRANTED = {
    "camera": camera,
    "media controller": lambda: os.close(os.open("/dev/media0", os.O_RDWR)),
    "a sensor behind it": lambda: os.close(os.open(sorted(glob.glob("/dev/v4l-subdev*"))[0], os.O_RDWR)),
    "record": record,
    "serve": serve,
    "sensors by UDP": sensors_by_udp,
    "sensors by a serial line": lambda: os.close(os.open("/dev/ttyS1", os.O_RDWR | os.O_NONBLOCK | os.O_NOCTTY)),
    "tell the service manager": lambda: notify(b"READY=1"),
    "humble child": lambda: in_child(lambda: os.nice(19)),
    "start a program": lambda: subprocess.run(["/bin/true"], check=True),
    "read settings": lambda: read("/etc/nadir/nadir.toml"),
}


def outcome(attempt):
    try:
        attempt()
        return ""
    except (OSError, subprocess.SubprocessError, ValueError, KeyError) as error:
        return str(error) or repr(error)


print(json.dumps({kind: {name: outcome(attempt) for name, attempt in attempts.items()} for kind, attempts in (("denied", DENIED), ("granted", GRANTED))}))
