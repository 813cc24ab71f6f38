# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""The kernel's virtual cameras can fail in the ways that the tests need."""
from machine import Failed

FAULTS = ("disconnect", "inject_fatal_streaming_error", "inject_v4l2_buf_flag_error", "inject_vidioc_reqbufs_error", "inject_vidioc_qbuf_error",
          "inject_vidioc_streamon_error", "percentage_of_dropped_buffers", "fill_percentage_of_frame", "timestamp_source")


def run(guest, nadir):
    guest.command("modprobe vivid n_devs=2 node_types=1,1 && udevadm settle")
    try:
        controls = guest.command("v4l2-ctl -d /dev/video0 --list-ctrls").out
        missing = [name for name in FAULTS if name not in controls]
        if missing:
            raise Failed("vivid has no " + ", ".join(missing))
        guest.command("v4l2-ctl -d /dev/video1 --stream-mmap --stream-count=5 --stream-to=/dev/null")
    finally:
        guest.command("rmmod vivid")
    return f"2 cameras, {len(FAULTS)} faults"
