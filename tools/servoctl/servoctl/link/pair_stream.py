# SPDX-License-Identifier: Apache-2.0
"""One object of both axes as a stream over borrowed PDOs, and with it set-points of position to them.

    ErrorStream       60F4 of both axes every 10 ms, over TPDO3
    PositionStream    6064 of both axes in every tick over TPDO3, the tick counter every 10 ms over TPDO4, and the target
                      positions 607A over RPDO4
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..drive.drive import Drive
from ..objects.parameter import AXES, AXIS_SHIFT
from ..units import POSITION_COUNTS_PER_RAD, POSITION_RANGE_RAD, TICK_S
from .borrowed_stream import BorrowedStream
from .device import Device
from .pdo_loan import PdoLoan, borrowed_identifiers
from .stream import CLOCK_TICKS, RATES_TPDO, RPDO, TICKS_TPDO, SampleGatherer

Real = NDArray[np.float64]

ERROR_TICKS = 10
CAMERA_EMERGENCY = 0x7000
"""Fault 55: frames of the camera do not count."""


def _both(index: int) -> list[int]:
    return [(index + AXIS_SHIFT * axis) << 16 | 32 for axis in range(len(AXES))]


def _radians(frames: list[bytes]) -> Real:
    """A row per frame, a column per axis."""
    return np.frombuffer(b"".join(frames), dtype="<i4").reshape(-1, 2).astype(np.float64) / POSITION_COUNTS_PER_RAD


class ErrorStream(BorrowedStream):
    """The following error of both axes, rad; in tracking the distance from the line of sight to the target."""

    def __init__(self, device: Device) -> None:
        self._errors = PdoLoan(device, 0x1800 + RATES_TPDO, 0x1A00 + RATES_TPDO)
        self._errors_id = borrowed_identifiers(device.node_id)[0]
        self._frames: list[bytes] = []
        super().__init__(device, 0, [self._errors], (self._errors_id,))

    def _take_emergency(self, identifier: int, data: bytearray, timestamp: float) -> None:
        """Not those of the camera: whoever tracks sees more of them in 3072, and its axes stop by themselves."""
        if int.from_bytes(data[:2], "little") != CAMERA_EMERGENCY:
            super()._take_emergency(identifier, data, timestamp)

    def _borrow(self) -> None:
        self._errors.take(self._errors_id, _both(0x60F4), event_ms=ERROR_TICKS)

    def _take(self, which: int, data: bytes, timestamp_s: float) -> None:
        if len(data) == 8:
            self._frames.append(data)

    def _forget(self) -> None:
        self._frames = []

    def count(self) -> int:
        """Frames since `start`, one every `ERROR_TICKS` ticks of the node."""
        with self.lock:
            return len(self._frames)

    def errors(self, first: int = 0) -> Real:
        """From this frame on."""
        with self.lock:
            frames = self._frames[first:]
        return _radians(frames)


class WrapCounter:
    """Counts how often the positions of both axes have left their range (607B)."""

    def __init__(self) -> None:
        self.ranges: list[tuple[int, int]] = []
        """Of each frame, since the first one."""
        self._before: tuple[int, int] | None = None

    def take(self, frame: bytes) -> None:
        """A frame with both positions."""
        now: tuple[int, int] = struct.unpack("<ii", frame)
        before, last = (self._before, self.ranges[-1]) if self._before else (now, (0, 0))
        self.ranges.append((last[0] + _wrapped(before[0], now[0]), last[1] + _wrapped(before[1], now[1])))
        self._before = now


def _wrapped(before: int, now: int) -> int:
    return round((before - now) / (POSITION_RANGE_RAD * POSITION_COUNTS_PER_RAD))


class PositionStream(BorrowedStream):
    """Positions and set-points of both axes; time counts from `start` in ticks of the node."""

    def __init__(self, device: Device) -> None:
        self._positions = PdoLoan(device, 0x1800 + RATES_TPDO, 0x1A00 + RATES_TPDO)
        self._clock = PdoLoan(device, 0x1800 + TICKS_TPDO, 0x1A00 + TICKS_TPDO)
        self._targets = PdoLoan(device, 0x1400 + RPDO, 0x1600 + RPDO)
        self._positions_id, self._targets_id, self._clock_id = borrowed_identifiers(device.node_id, 3)
        self._gatherer = SampleGatherer()
        self._ticks: list[int] = []
        self._wrapped = WrapCounter()
        self._wraps = [Drive(device, axis).wraps() for axis in range(len(AXES))]
        self.late = 0
        """Delay of the latest set-point of `pace`, in ticks."""
        super().__init__(
            device, 0, [self._positions, self._clock, self._targets], (self._positions_id, self._clock_id)
        )

    def _borrow(self) -> None:
        self._positions.take(self._positions_id, _both(0x6064), event_ms=1)
        self._clock.take(self._clock_id, [0x3010 << 16 | 1 << 8 | 32], event_ms=CLOCK_TICKS)
        self._targets.take(self._targets_id, _both(0x607A), event_ms=0)

    def _take(self, which: int, data: bytes, timestamp_s: float) -> None:
        if which == 0 and len(data) == 8:
            self._gatherer.take_sample(data)
            if self._gatherer.ticks >= 0:
                self._wrapped.take(data)
                self._ticks.append(self._gatherer.ticks)
        elif which == 1 and len(data) == 4:
            self._gatherer.take_clock(int.from_bytes(data, "little"))

    def _forget(self) -> None:
        self._gatherer = SampleGatherer()
        self._ticks = []
        self._wrapped = WrapCounter()
        self.late = 0

    def pace(self, period: int, count: int) -> Iterator[int]:
        """Yields the tick, about every `period` of them, until `count`; late ones are skipped, not made up for."""
        next_tick = 0
        while True:
            with self.lock:
                while self._gatherer.ticks < next_tick:
                    self.lock.wait(0.05)
                    self.check_alive()
                tick = self._gatherer.ticks
            if tick >= count:
                return
            self.late = max(self.late, tick - next_tick)
            yield tick
            next_tick = (tick // period + 1) * period

    def send(self, azimuth_rad: float, pitch_rad: float) -> None:
        """Target positions."""
        angles = [
            angle - POSITION_RANGE_RAD * round(angle / POSITION_RANGE_RAD) if wraps else angle
            for angle, wraps in zip((azimuth_rad, pitch_rad), self._wraps, strict=True)
        ]
        counts = [round(angle * POSITION_COUNTS_PER_RAD) for angle in angles]
        self.device.network.send_message(self._targets_id, struct.pack("<ii", *counts))

    def positions(self, first: int = 0) -> tuple[Real, Real]:
        """Times since `start` (s), and a row per time with a column per axis (rad), from this sample on; lost ones are
        left out."""
        with self.lock:
            frames, ticks = self._gatherer.frames[first:], self._ticks[first:]
            ranges = np.array(self._wrapped.ranges[first:], dtype=np.float64).reshape(-1, 2)
        return TICK_S * np.array(ticks, dtype=np.float64), _radians(frames) + POSITION_RANGE_RAD * ranges

    def lost(self) -> int:
        """Missing samples, by the node's tick counter."""
        return self._gatherer.lost
