"""The camera frame of docs/can.md: what the imager sends, and how the node is prepared to take it."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import can
from servoctl.device import Device
from servoctl.pdo_loan import PdoLoan

RPDO = 4
CAMERA_ID = 0x540
"""Plus node id, as `sim_host serve --target`: no PDO of a node with a low id has it as delivered."""
OBJECTS = [0x30700110, 0x30700210, 0x30700310, 0x30700408, 0x30700508]
SCALE, TIME_KIND = (0x3071, 1), (0x3071, 5)
AGE, NODE_CLOCK = 0, 1
"""Meanings of the time: 3071:5."""
TIME_S = 1e-5
_CLIPPED = 0x7FFF
DROPS = {
    1: "not newer than the last one (does another camera send?)",
    2: "older than 127 ms",
    3: "exposed later than now",
    4: "quality above 100",
}
"""3072:4."""


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


@dataclass(frozen=True)
class NodeReport:
    """What became of the frames, as the node counts them since it started."""

    taken: int
    dropped: int
    last_drop: int
    age_ms: int


class FrameSender:
    """Sends camera frames to one node. Use in a `with` block: afterwards RPDO4 and 3071:5 are as they were."""

    def __init__(self, device: Device, time_kind: int) -> None:
        self._device = device
        self._kind = time_kind
        self._identifier = CAMERA_ID + device.node_id
        self._loan = PdoLoan(device, 0x1400 + RPDO - 1, 0x1600 + RPDO - 1)
        self._counter = 0
        self.sent = 0

    def __enter__(self) -> FrameSender:
        self.scale_rad = float(struct.unpack("<f", self._device.upload(*SCALE, "camera image scale"))[0])
        self._kind_before = self._device.read_int(*TIME_KIND)
        self._device.write_int(*TIME_KIND, self._kind, 1)
        self._loan.take(self._identifier, OBJECTS, 0)
        self.at_start = self.report()
        return self

    def __exit__(self, *_: object) -> None:
        self._loan.give_back()
        self._device.write_int(*TIME_KIND, self._kind_before, 1)

    def send(self, result: Result) -> None:
        """One frame, one more of the counter."""
        self._counter += 1
        data = payload(result, self.scale_rad, self._kind, self._counter)
        bus = self._device.network.bus
        assert bus is not None
        bus.send(can.Message(arbitration_id=self._identifier, is_extended_id=False, data=data))
        self.sent += 1

    def report(self) -> NodeReport:
        """Read by SDO."""
        return NodeReport(*(self._device.read_int(0x3072, sub) for sub in (1, 3, 4, 7)))
