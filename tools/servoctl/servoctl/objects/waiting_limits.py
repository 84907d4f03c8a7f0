# SPDX-License-Identifier: Apache-2.0
"""Limits that contradict each other: the device accepts each write, keeps the old set in effect and waits (2060:18).

So a command that leaves limits waiting has not done its work.
"""

from __future__ import annotations

from collections.abc import Iterable

from ..errors import Refused
from ..link.device import Device
from .parameter import AXES, AXIS_SHIFT, Parameter

PROTECTION, TRAVEL, WAITING_SUB = 0x2060, 0x607D, 18

GROUPS = {
    1: "the under-voltage limit (2060:15) must be below the over-voltage limit (2060:16)",
    2: "the travel between the hard limits (2060:9, 2060:10) must be more than twice the stopping margin (2060:17)",
    4: "the software minimum (607D:1) must not be above the maximum (607D:2)",
}
"""The violated condition, by its bit of 2060:18."""


def refuse_waiting(device: Device, written: Iterable[Parameter]) -> None:
    """Raises Refused when written limits wait because they contradict others."""
    touched = {p.axis for p in written if p.axis is not None and p.index - AXIS_SHIFT * p.axis in (PROTECTION, TRAVEL)}
    for axis in sorted(touched):
        found = device.schema.by_index(PROTECTION + AXIS_SHIFT * axis, WAITING_SUB)
        waiting = device.read_int(found.index, found.sub) if found is not None else 0
        reasons = [words for bit, words in GROUPS.items() if waiting & bit]
        if reasons:
            raise Refused(
                f"{AXES[axis]}: the limits contradict each other, the old ones stay active: {'; '.join(reasons)}."
                " Give limits that belong together in one command."
            )
