# SPDX-License-Identifier: Apache-2.0
"""The ticks of an identification as signals for a live view, while the recorder has the stream: it has the same members as
a SignalStream."""

from __future__ import annotations

import numpy as np

from ..link.signal_stream import Samples, Signal
from ..objects.parameter import AXES
from ..units import TICK_S, degrees
from .recorder import TickRecorder, decode

TICK_BYTES = 24
_COLUMNS = ("joint_angle_rad", "joint_rate_rad_s", "torque_nm")


class RecordedSignals:
    """Angle, rate and torque of the axis that is identified."""

    def __init__(self, recorder: TickRecorder, axis: int, near_rad: float) -> None:
        """`near_rad`: about where the axis is."""
        self.signals = (
            Signal(f"{AXES[axis]} angle", axis, 0x2101, "°", degrees(1.0), "angle", 4, "u4"),
            Signal(f"{AXES[axis]} joint rate", axis, 0x2101, "°/s", degrees(1.0), "rate", 5, "f4"),
            Signal(f"{AXES[axis]} torque", axis, 0x2101, "N m", 1.0, "torque", 7, "f4"),
        )
        self.period_ms = round(1e3 * TICK_S)
        self.note = f"{len(self.signals)} signals, as they are recorded for the identification of {AXES[axis]}."
        self._recorder = recorder
        self._near_rad = near_rad
        self._taken = 0
        self._tick = 0
        self._last_number: int | None = None

    @property
    def missing(self) -> int:
        """Ticks that did not come, or not whole."""
        return self._recorder.missing

    def take(self) -> Samples:
        """What has come since the last time. A new part of the identification begins its recording anew."""
        frames, whole = self._recorder.frames_from(self._taken)
        if whole < self._taken:
            self._taken = 0
        if not frames:
            return Samples(np.zeros(0, np.uint32), np.zeros((len(self.signals), 0), np.float32))
        self._taken += len(frames)
        found = decode(frames, self._near_rad)
        first = int.from_bytes(frames[16:18], "little")
        self._tick += (first - self._last_number) & 0xFFFF if self._last_number is not None else 1
        ticks = self._tick + np.round(found.time_s / TICK_S).astype(np.int64)
        self._tick = int(ticks[-1])
        self._last_number = int.from_bytes(frames[-TICK_BYTES + 16 : -TICK_BYTES + 18], "little")
        self._near_rad = float(found.joint_angle_rad[-1])
        values = np.array([s.factor * getattr(found, c) for s, c in zip(self.signals, _COLUMNS, strict=True)], np.float32)
        return Samples((ticks & 0xFFFFFFFF).astype(np.uint32), values)
