# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""A camera that loses and damages images, fails and is torn off: each is told, and none ends the service."""
from machine import Failed

LOST_S, BACK_S = 1, 3
COUNTED_S = 12  # losses are told together


def run(guest, nadir):
    nadir.take_vivid()
    process = nadir.process()
    took = {}

    def inject(control, value=1):
        return guest.command(f"v4l2-ctl -d /dev/video0 -c {control}={value}").begin

    since = inject("percentage_of_dropped_buffers", 50)
    took["lost images"] = nadir.expect("^images_dropped: .*lost on the way", since, COUNTED_S)
    since = inject("percentage_of_dropped_buffers", 0)
    for _ in range(3):
        since = inject("inject_v4l2_buf_flag_error")
        guest.command("sleep 0.3")
    took["damaged images"] = nadir.expect("^images_dropped: .*damaged", since, COUNTED_S)
    since = inject("inject_fatal_streaming_error")
    took["failed"] = nadir.expect("^camera_lost", since, LOST_S)
    took["back"] = nadir.expect("^camera_back", since + took["failed"], BACK_S)
    since = inject("disconnect")
    took["torn off"] = nadir.expect("^camera_lost", since, LOST_S)
    nadir.unplug_vivid()
    took["plugged in"] = nadir.expect("^camera_back", nadir.plug_in_vivid(), BACK_S)
    if nadir.process() != process:
        raise Failed(f"the service started again\n{nadir.log()}")
    return "told after: " + ", ".join(f"{what} {seconds:.2f} s" for what, seconds in took.items())
