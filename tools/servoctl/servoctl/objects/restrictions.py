# SPDX-License-Identifier: Apache-2.0
"""Why protection does not enable an axis, or lets it move slowly only (2061:1)."""

from __future__ import annotations

from ..link.device import Device
from .parameter import AXES

ENVELOPE, RESTRICTIONS_SUB, LOWEST_SUB, HIGHEST_SUB, AXIS_SHIFT = 0x2061, 1, 3, 4, 0x800

NO_TRAVEL, UNKNOWN_TURN, COMMISSIONING = 1, 2, 4
BANKS_AS_NEEDED = 0x80
"""Of 3061:1."""


def turn_is_unknown(device: Device, axis: int) -> bool:
    """Several turns are possible, and the axis moves slowly."""
    return bool(device.read_int(ENVELOPE + AXIS_SHIFT * axis, RESTRICTIONS_SUB) & UNKNOWN_TURN)


def possible_turns(device: Device, axis: int) -> tuple[int, int]:
    """Lowest and highest; the lowest above the highest: none is within the travel."""
    lowest, highest = (device.read_int(ENVELOPE + AXIS_SHIFT * axis, sub, signed=True) for sub in (LOWEST_SUB, HIGHEST_SUB))
    return lowest, highest


def reason(device: Device, axis: int) -> str | None:
    """One sentence for people, or None when nothing restricts the axis or the node is older than 2061."""
    status = device.try_upload(0x3061, 1)
    if status is not None and not int.from_bytes(status, "little") & BANKS_AS_NEEDED:
        return (
            "the flash of its chip has other banks than the image needs, so it gives no torque and stores nothing. Set the"
            " option bytes DBANK and BFB2 with tools/image/board options."
        )
    found = device.schema.by_index(ENVELOPE + AXIS_SHIFT * axis, RESTRICTIONS_SUB)
    if found is None:
        return None
    bits = device.read_int(found.index, found.sub)
    if bits & NO_TRAVEL:
        return (
            "it has no travel limits. Set 2060:9 and 2060:10, or 2060:21 = 1 for a machine without end stops, or"
            " 2060:21 = 2 to find them at 5 °/s at most (servoctl set --unlock)."
        )
    if bits & UNKNOWN_TURN:
        lowest, highest = possible_turns(device, axis)
        turns = f"{lowest} to {highest}" if lowest <= highest else "none is within the travel limits"
        name = AXES[axis]
        return (
            f"the encoder does not show in which turn {name} started (possible: {turns}). It moves at 5 °/s at most,"
            f" and not to positions, until motion has excluded all turns but one, or until you confirm the turn:"
            f" servoctl home {name} --down, --up, or --seen ANGLE --unlock."
        )
    if bits & COMMISSIONING:
        return "2060:21 is 2 (commissioning): it moves at 5 °/s at most."
    return None
