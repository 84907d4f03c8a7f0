# SPDX-License-Identifier: Apache-2.0
"""State of an axis as the device reports it, read by SDO."""

from __future__ import annotations

from typing import Any

from ..link.device import Device
from ..objects.parameter import AXES, AXIS_SHIFT
from ..units import POSITION_COUNTS_PER_RAD, RATE_COUNTS_PER_RAD_S, degrees
from .drive import Drive


def read_axis(device: Device, axis: int) -> dict[str, Any]:
    """Power state, mode, angle (°), rate (°/s), torque (% of rated) of an axis, from the device."""
    drive = Drive(device, axis)
    status = drive.statusword()
    torque = device.try_upload(0x6077 + AXIS_SHIFT * axis)
    position = device.try_upload(0x6064 + AXIS_SHIFT * axis)
    rate = device.try_upload(0x606C + AXIS_SHIFT * axis)
    code = device.try_upload(0x603F + AXIS_SHIFT * axis)

    def whole(data: bytes | None) -> int | None:
        return None if data is None else int.from_bytes(data, "little", signed=True)

    counts, speed, load = whole(position), whole(rate), whole(torque)
    return {
        "axis": AXES[axis],
        "state": drive.state(status),
        "flags": drive.flags(status),
        "mode": drive.mode(),
        "position_deg": None if counts is None else degrees(counts / POSITION_COUNTS_PER_RAD),
        "rate_deg_s": None if speed is None else degrees(speed / RATE_COUNTS_PER_RAD_S),
        "torque_percent": None if load is None else load / 10.0,
        "error": int.from_bytes(code, "little") if code else 0,
    }
