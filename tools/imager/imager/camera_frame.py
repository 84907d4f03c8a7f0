# SPDX-License-Identifier: Apache-2.0
"""The camera frame of docs/can.md: what the imager sends, and how the node is prepared to take it."""

from __future__ import annotations

import struct
from contextlib import ExitStack
from dataclasses import dataclass

import can
from servoctl.link.device import Device
from servoctl.motion.tracking import CameraMapping, FrameCounts, frame_counts

CAMERA_ID = 0x540
"""Plus node id, as `sim_host serve --target`: no PDO of a node with a low id has it as delivered."""
SCALE, TIME_KIND = (0x3071, 1), (0x3071, 5)
AGE, NODE_CLOCK, STROBE = 0, 1, 2
"""3071:5: meanings of the time, and the bit by which the strobe is used beside them."""
TIME_S = 1e-5
_CLIPPED = 0x7FFF


@dataclass(frozen=True)
class Result:
    """Of one picture: tangents, and the time as 3071:5 says, s."""

    x_rad: float
    y_rad: float
    time_s: float
    quality: int


def payload(result: Result, scale_rad: float, time_kind: int, counter: int) -> bytes:
    """The 8 bytes; an error beyond the range is clipped, an age too. Without a target the errors are 0."""
    time = round(result.time_s / TIME_S)
    time = time % 0x10000 if time_kind == NODE_CLOCK else min(max(time, 0), 0xFFFF)
    errors = (result.x_rad, result.y_rad) if result.quality else (0.0, 0.0)
    counts = (min(max(round(error / scale_rad), -_CLIPPED), _CLIPPED) for error in errors)
    return struct.pack("<hhHBB", *counts, time, result.quality, counter % 256)


class FrameSender:
    """Sends camera frames to one node. Use in a `with` block: afterwards RPDO4 and 3071:5 are as they were. The strobe
    stays as it is used."""

    def __init__(self, device: Device, time_kind: int) -> None:
        self._device = device
        self._kind = time_kind
        self._identifier = CAMERA_ID + device.node_id
        self._mapping = CameraMapping(device, self._identifier)
        self._counter = 0
        self.sent = 0
        self.clipped = 0
        """Frames whose error was beyond the range."""

    def __enter__(self) -> FrameSender:
        self.scale_rad = float(struct.unpack("<f", self._device.upload(*SCALE, "camera image scale"))[0])
        before = self._device.read_int(*TIME_KIND)
        with ExitStack() as undo:
            undo.callback(self._device.write_int, *TIME_KIND, before, 1)
            self._device.write_int(*TIME_KIND, self._kind | before & STROBE, 1)
            undo.enter_context(self._mapping)
            self.at_start = self.report()
            self._undo = undo.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._undo.close()

    def send(self, result: Result) -> None:
        """One frame, one more of the counter."""
        self._counter += 1
        data = payload(result, self.scale_rad, self._kind, self._counter)
        bus = self._device.network.bus
        assert bus is not None
        bus.send(can.Message(arbitration_id=self._identifier, is_extended_id=False, data=data))
        self.sent += 1
        self.clipped += bool(result.quality) and max(abs(result.x_rad), abs(result.y_rad)) > self.range_rad

    @property
    def range_rad(self) -> float:
        """Largest error of a frame: 3071:1 times the counts."""
        return self.scale_rad * _CLIPPED

    def report(self) -> FrameCounts:
        """Read by SDO."""
        return frame_counts(self._device)
