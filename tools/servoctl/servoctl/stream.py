"""A fast stream of samples from one axis, and a fast stream of set-points to it, over PDOs borrowed for the time.

TPDO4 sends demanded rate (606B) and measured rate (606C) of the same tick every 1 ms; RPDO4 takes the target rate
(60FF). Both get an identifier of their own while borrowed, so that a listener that knows the default mapping sees
nothing rather than something wrong, and no other master's frames come in. Afterwards both are as before.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from .borrowed_stream import BorrowedStream
from .device import Device
from .parameter import AXIS_SHIFT
from .pdo_loan import PdoLoan, borrowed_identifiers
from .units import RATE_COUNTS_PER_RAD_S

TICK_S = 0.001
TPDO, RPDO = 3, 3
"""TPDO4 and RPDO4, counted from 0."""

Samples = NDArray[np.float64]


class RateStream(BorrowedStream):
    """Demand and answer of one axis at 1 kHz."""

    silent_s = 0.25

    def __init__(self, device: Device, axis: int, period_ms: int = 1) -> None:
        self.period_s = period_ms * TICK_S
        self._period_ms = period_ms
        self._tpdo = PdoLoan(device, 0x1800 + TPDO, 0x1A00 + TPDO)
        self._rpdo = PdoLoan(device, 0x1400 + RPDO, 0x1600 + RPDO)
        self._out_id, self._in_id, _ = borrowed_identifiers(device.node_id)
        self._frames: list[bytes] = []
        self._times_s: list[float] = []
        super().__init__(device, axis, [self._tpdo, self._rpdo], (self._out_id,))

    def _borrow(self) -> None:
        shift = AXIS_SHIFT * self.axis
        self._tpdo.take(self._out_id, [(0x606B + shift) << 16 | 32, (0x606C + shift) << 16 | 32], self._period_ms)
        self._rpdo.take(self._in_id, [(0x60FF + shift) << 16 | 32], 0)

    def _take(self, which: int, data: bytes, timestamp_s: float) -> None:
        self._frames.append(data)
        self._times_s.append(timestamp_s)

    def _forget(self) -> None:
        self._frames.clear()
        self._times_s.clear()

    def send(self, rate_rad_s: float) -> None:
        """A target rate, rad/s."""
        self.device.network.send_message(self._in_id, struct.pack("<i", round(rate_rad_s * RATE_COUNTS_PER_RAD_S)))

    def latest(self) -> float | None:
        """The last measured rate, rad/s."""
        with self.lock:
            return struct.unpack_from("<i", self._frames[-1], 4)[0] / RATE_COUNTS_PER_RAD_S if self._frames else None

    def samples(self) -> tuple[Samples, Samples]:
        """Demand and answer in rad/s, one sample every `period_s`, both of the same tick."""
        with self.lock:
            raw = np.frombuffer(b"".join(self._frames), dtype="<i4").reshape(-1, 2)
        values = raw.astype(np.float64) / RATE_COUNTS_PER_RAD_S
        return values[:, 0], values[:, 1]

    def lost(self) -> int:
        """Frames missing, by the time stamps of the first and the last."""
        with self.lock:
            if len(self._times_s) < 2:
                return 0
            expected = round((self._times_s[-1] - self._times_s[0]) / self.period_s) + 1
            return max(0, expected - len(self._times_s))
