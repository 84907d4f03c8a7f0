# SPDX-License-Identifier: Apache-2.0
"""A quick stop of both axes without waiting for anything: the controlwords in RPDO1 and RPDO2.

An SDO transfer waits for its turn, and for the answer to the one before. These two frames do not: any thread sends them,
at any time. They carry the mode that the axis has, so that they change nothing else. A controlword that stops is obeyed
whatever else its frame holds (docs/can.md). They work while the node is operational, as it is while an axis is enabled.
"""

from __future__ import annotations

import contextlib
import struct

import can

from ..drive import power
from ..objects.parameter import AXES, AXIS_SHIFT
from .device import Device

_OFF = 0x80000000


class StopFrames:
    """The frames, made when the node is opened; they are empty when a master has mapped RPDO1 or RPDO2 differently."""

    def __init__(self, device: Device) -> None:
        self._network = device.network
        self._identifiers = [_identifier(device, axis) for axis in range(len(AXES))]
        self._modes = [0] * len(AXES)

    def note_mode(self, axis: int, mode: int) -> None:
        """The mode of the axis (6060), which the frame repeats."""
        self._modes[axis] = mode

    @property
    def complete(self) -> bool:
        """Both frames can be sent."""
        return None not in self._identifiers

    def send(self) -> bool:
        """Both frames; False when one of them could not be sent: then only the SDO stops."""
        sent = True
        for identifier, mode in zip(self._identifiers, self._modes, strict=True):
            if identifier is None:
                sent = False
                continue
            with contextlib.suppress(can.CanError, OSError, RuntimeError):
                self._network.send_message(identifier, struct.pack("<Hb", power.QUICK_STOP, mode))
                continue
            sent = False
        return sent


def _identifier(device: Device, axis: int) -> int | None:
    """Of RPDO1 + axis, if it takes controlword and mode of this axis and nothing else."""
    data = device.try_upload(0x1400 + axis, 1)
    expected = [(0x6040 + AXIS_SHIFT * axis) << 16 | 16, (0x6060 + AXIS_SHIFT * axis) << 16 | 8]
    if data is None or int.from_bytes(data, "little") & _OFF or device.read_int(0x1600 + axis) != len(expected):
        return None
    found = [device.read_int(0x1600 + axis, sub) for sub in range(1, len(expected) + 1)]
    return int.from_bytes(data, "little") & 0x7FF if found == expected else None
