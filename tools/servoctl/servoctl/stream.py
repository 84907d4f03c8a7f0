"""A fast stream of samples from one axis, and a fast stream of set-points to it, over PDOs borrowed for the time.

TPDO4 sends demanded rate (606B) and measured rate (606C) of the same tick every 1 ms; RPDO4 takes the target rate
(60FF). Both get an identifier of their own while borrowed, so that a listener that knows the default mapping sees
nothing rather than something wrong, and no other master's frames come in. Afterwards both are as before.
"""

from __future__ import annotations

import contextlib
import struct
import threading
import time
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from .device import Device
from .errors import MotionError, ServoctlError
from .parameter import AXIS_SHIFT
from .pdo_loan import PdoLoan, borrowed_identifiers
from .units import RATE_COUNTS_PER_RAD_S

TICK_S = 0.001
TPDO, RPDO = 3, 3
"""TPDO4 and RPDO4, counted from 0."""

ACTUAL_LAG_TICKS = 1
"""606C of a frame is one tick older than its 606B: the drive computes the demand before the axis senses the rate."""

SILENT_S = 0.25

Samples = NDArray[np.float64]


class RateStream:
    """Demand and answer of one axis at 1 kHz, in a `with` block; the node must be operational for frames to come."""

    def __init__(self, device: Device, axis: int, period_ms: int = 1) -> None:
        self.device = device
        self.axis = axis
        self.period_s = period_ms * TICK_S
        self._period_ms = period_ms
        self._tpdo = PdoLoan(device, 0x1800 + TPDO, 0x1A00 + TPDO)
        self._rpdo = PdoLoan(device, 0x1400 + RPDO, 0x1600 + RPDO)
        self._out_id, self._in_id, _ = borrowed_identifiers(device.node_id)
        self._frames: list[bytes] = []
        self._times: list[float] = []
        self._lock = threading.Lock()
        self._last_frame_s = time.monotonic()
        self.emergency: tuple[int, bytes] | None = None
        self._turn = contextlib.ExitStack()

    def __enter__(self) -> RateStream:
        shift = AXIS_SHIFT * self.axis
        network = self.device.network
        self._turn.enter_context(
            self.device.turns.alone("stream", "another servoctl is measuring (step or bode) at this node: wait until it is done.")
        )
        network.subscribe(self._out_id, self._take)
        network.subscribe(0x80 + self.device.node_id, self._take_emergency)
        try:
            self._tpdo.take(self._out_id, [(0x606B + shift) << 16 | 32, (0x606C + shift) << 16 | 32], self._period_ms)
            self._rpdo.take(self._in_id, [(0x60FF + shift) << 16 | 32], 0)
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        first: ServoctlError | None = None
        for loan in (self._tpdo, self._rpdo):
            try:
                loan.give_back()
            except ServoctlError as failed:
                first = first or failed
        self.device.network.unsubscribe(self._out_id, self._take)
        self.device.network.unsubscribe(0x80 + self.device.node_id, self._take_emergency)
        self._turn.close()
        if first is not None and error is None:
            raise first

    def _take(self, _identifier: int, data: bytearray, timestamp: float) -> None:
        if len(data) == 8:
            with self._lock:
                self._frames.append(bytes(data))
                self._times.append(timestamp)
                self._last_frame_s = time.monotonic()

    def _take_emergency(self, _identifier: int, data: bytearray, _timestamp: float) -> None:
        code = int.from_bytes(data[:2], "little")
        if code:
            self.emergency = (code, bytes(data))

    def send(self, rate_rad_s: float) -> None:
        """A target rate, rad/s."""
        self.device.network.send_message(self._in_id, struct.pack("<i", round(rate_rad_s * RATE_COUNTS_PER_RAD_S)))

    def start(self) -> None:
        """Forgets what came until now."""
        with self._lock:
            self._frames.clear()
            self._times.clear()
            self._last_frame_s = time.monotonic()

    def latest(self) -> float | None:
        """The last measured rate, rad/s."""
        with self._lock:
            return struct.unpack_from("<i", self._frames[-1], 4)[0] / RATE_COUNTS_PER_RAD_S if self._frames else None

    def check_alive(self) -> None:
        """Raises MotionError after an emergency message, or when the frames have stopped."""
        if self.emergency is not None:
            raise MotionError(
                f"the node sent an emergency (code {self.emergency[0]:04X}): 'servoctl faults' tells more."
            )
        if time.monotonic() - self._last_frame_s > SILENT_S:
            raise MotionError(f"the node has sent no samples for {SILENT_S:g} s.")

    def samples(self) -> tuple[Samples, Samples]:
        """Demand and answer in rad/s, one sample every `period_s`, both of the same tick: the lag is taken out."""
        with self._lock:
            raw = np.frombuffer(b"".join(self._frames), dtype="<i4").reshape(-1, 2)
        values = raw.astype(np.float64) / RATE_COUNTS_PER_RAD_S
        lag = ACTUAL_LAG_TICKS if self._period_ms == 1 else 0
        return values[: len(values) - lag, 0], values[lag:, 1]

    def lost(self) -> int:
        """Frames missing, by the time stamps of the first and the last."""
        with self._lock:
            if len(self._times) < 2:
                return 0
            expected = round((self._times[-1] - self._times[0]) / self.period_s) + 1
            return max(0, expected - len(self._times))
