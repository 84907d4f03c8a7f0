# SPDX-License-Identifier: Apache-2.0
"""A fast stream of samples from one axis, and a fast stream of set-points to it, over temporarily borrowed PDOs.

TPDO3 sends demanded rate (606B) and measured rate (606C) of the same tick every 1 ms; TPDO4 sends the node's tick
counter (3010:1) every 10 ms, in the same tick after TPDO3; RPDO4 takes the target rate (60FF). So the stream itself
carries the node's time: it paces set-points and counts lost samples, whatever the pace of the node's time relative to
the computer's. All three get an identifier of their own while borrowed, so that a listener that knows the default
mapping receives nothing instead of wrong values, and no frames of other masters come in. Afterwards all are restored.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..errors import MotionError
from ..objects.parameter import AXIS_SHIFT
from ..units import RATE_COUNTS_PER_RAD_S, TICK_S
from .borrowed_stream import BorrowedStream
from .device import Device
from .pdo_loan import PdoLoan, borrowed_identifiers

RATES_TPDO, TICKS_TPDO, RPDO = 2, 3, 3
"""TPDO3, TPDO4 and RPDO4, counted from 0: TPDOs of one tick are sent in the order of their numbers and identifiers."""
CLOCK_TICKS = 10
"""Period of the tick counter."""
PROBES, PROBE_TICKS = 5, 20
"""Set-points sent to check that the node receives them, and how long each may take to arrive."""
_WRAP = 1 << 32

Samples = NDArray[np.float64]


class SampleGatherer:
    """Combines samples and the node's tick counter, in the order in which their frames came.

    Samples count from the first frame of the tick counter on.
    """

    def __init__(self) -> None:
        self.frames: list[bytes] = []
        self.last: bytes | None = None
        self.lost = 0
        self._first_tick: int | None = None
        self._clock_tick = 0
        self._since_clock = 0

    def take_sample(self, data: bytes) -> None:
        """The frame of a tick: demand and answer."""
        self.last = data
        if self._first_tick is not None:
            self.frames.append(data)
            self._since_clock += 1

    def take_clock(self, tick: int) -> None:
        """The tick counter; the sample of this tick is the one before it."""
        if self._first_tick is None:
            self._first_tick = tick
        else:
            self.lost += max(0, (tick - self._clock_tick) % _WRAP - self._since_clock)
        self._clock_tick = tick
        self._since_clock = 0

    @property
    def ticks(self) -> int:
        """Ticks since the first frame of the tick counter; -1 before it."""
        if self._first_tick is None:
            return -1
        return (self._clock_tick - self._first_tick) % _WRAP + self._since_clock


class RateStream(BorrowedStream):
    """Demand and answer of one axis at 1 kHz; its time is counted from `start` in ticks of the node."""

    def __init__(self, device: Device, axis: int) -> None:
        self._rates = PdoLoan(device, 0x1800 + RATES_TPDO, 0x1A00 + RATES_TPDO)
        self._clock = PdoLoan(device, 0x1800 + TICKS_TPDO, 0x1A00 + TICKS_TPDO)
        self._targets = PdoLoan(device, 0x1400 + RPDO, 0x1600 + RPDO)
        self._rates_id, self.targets_id, self._clock_id = borrowed_identifiers(device.node_id, 3)
        self._gatherer = SampleGatherer()
        self._late = 0
        super().__init__(
            device, axis, [self._rates, self._clock, self._targets], (self._rates_id, self._clock_id)
        )

    def _borrow(self) -> None:
        shift = AXIS_SHIFT * self.axis
        self._rates.take(self._rates_id, [(0x606B + shift) << 16 | 32, (0x606C + shift) << 16 | 32], event_ms=1)
        self._clock.take(self._clock_id, [0x3010 << 16 | 1 << 8 | 32], event_ms=CLOCK_TICKS)
        self._targets.take(self.targets_id, [(0x60FF + shift) << 16 | 32], event_ms=0)

    def _take(self, which: int, data: bytes, timestamp_s: float) -> None:
        if which == 0 and len(data) == 8:
            self._gatherer.take_sample(data)
        elif which == 1 and len(data) == 4:
            self._gatherer.take_clock(int.from_bytes(data, "little"))

    def _forget(self) -> None:
        self._gatherer = SampleGatherer()
        self._late = 0

    # --- the node's time ------------------------------------------------------------------------------------------

    def ticks(self) -> int:
        """Since `start`; -1 before the node has reported its time."""
        return self._gatherer.ticks

    def wait_until(self, tick: int) -> int:
        """Returns the present tick; raises MotionError when the stream stops."""
        with self.lock:
            while self.ticks() < tick:
                self.lock.wait(0.05)
                self.check_alive()
            return self.ticks()

    def pace(self, period: int, count: int) -> Iterator[int]:
        """Yields the tick, about every `period` of them, until `count`; late ones are skipped, not made up for."""
        next_tick = 0
        while True:
            tick = self.wait_until(next_tick)
            if tick >= count:
                return
            self._late = max(self._late, tick - next_tick)
            yield tick
            next_tick = (tick // period + 1) * period

    def late(self) -> int:
        """Delay of the latest set-point of `pace`, in ticks."""
        return self._late

    # --- set-points -----------------------------------------------------------------------------------------------

    def send(self, rate_rad_s: float) -> None:
        """A target rate, rad/s."""
        self._send(round(rate_rad_s * RATE_COUNTS_PER_RAD_S))

    def _send(self, counts: int) -> None:
        self.device.network.send_message(self.targets_id, struct.pack("<i", counts))

    def check_heard(self) -> None:
        """Raises MotionError when set-points do not arrive at the node; the axis is in a mode with target rates, and at
        rest.

        A target of 1 or 2 micro-rad/s is sent like the set-points, and read back by SDO (60FF).
        """
        for probe in range(1, PROBES + 1):
            counts = 1 + probe % 2
            self._send(counts)
            self.device.clock.sleep(PROBE_TICKS * TICK_S)
            if self.device.axis_int(self.axis, 0x60FF, signed=True) == counts:
                self._send(0)
                return
        raise MotionError(self.not_heard())

    def not_heard(self) -> str:
        """The sentence about it."""
        node = self.device.node_id
        return (
            f"node {node} does not receive identifier {self.targets_id:03X}, which carries the set-points"
            f" (RPDO{RPDO + 1}), but answers SDO ({0x600 + node:03X}). Check that its firmware is up to date (its"
            " CAN filter has to pass 680 to 6DF), and that no gateway in between blocks this identifier."
        )

    # --- samples --------------------------------------------------------------------------------------------------

    def latest(self) -> float | None:
        """The last measured rate, rad/s."""
        with self.lock:
            last = self._gatherer.last
        return struct.unpack_from("<i", last, 4)[0] / RATE_COUNTS_PER_RAD_S if last else None

    def samples(self) -> tuple[Samples, Samples]:
        """Demand and response in rad/s, one sample of both for each tick; lost ones are left out."""
        with self.lock:
            raw = np.frombuffer(b"".join(self._gatherer.frames), dtype="<i4").reshape(-1, 2)
        values = raw.astype(np.float64) / RATE_COUNTS_PER_RAD_S
        return values[:, 0], values[:, 1]

    def lost(self) -> int:
        """Missing samples, by the node's tick counter."""
        return self._gatherer.lost
