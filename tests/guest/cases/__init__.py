# SPDX-FileCopyrightText: nadir contributors
# SPDX-License-Identifier: Apache-2.0
"""Each case is a module with run(guest, nadir), which returns its figures or raises Failed. In this order they share one guest."""
ALL = ("vivid", "disk", "service", "page", "link", "sandbox", "missing", "hang", "kill", "camera", "faults", "libcamera", "power", "command")
