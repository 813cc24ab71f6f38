# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""stop_thread.py PID NAME: stops the one thread of that name and holds it until the process has gone. Prints when it stopped."""
import ctypes
import glob
import os
import sys
import time

PTRACE_SEIZE, PTRACE_INTERRUPT = 0x4206, 0x4207
WAIT_ALL = 0x40000000
libc = ctypes.CDLL(None, use_errno=True)
libc.ptrace.argtypes = [ctypes.c_long] * 4


def ptrace(request, thread):
    if libc.ptrace(request, thread, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def main(process, name):
    named = [task for task in glob.glob(f"/proc/{process}/task/*") if open(task + "/comm").read().strip() == name]
    if len(named) != 1:
        names = sorted(open(task + "/comm").read().strip() for task in glob.glob(f"/proc/{process}/task/*"))
        sys.exit(f"no single thread {name} among {' '.join(names)}")
    thread = int(os.path.basename(named[0]))
    ptrace(PTRACE_SEIZE, thread)
    ptrace(PTRACE_INTERRUPT, thread)
    os.waitpid(thread, WAIT_ALL)
    print(f"stopped {time.monotonic():.3f}", flush=True)
    while True:
        _, status = os.waitpid(thread, WAIT_ALL)
        if os.WIFEXITED(status) or os.WIFSIGNALED(status):
            return


main(*sys.argv[1:])
