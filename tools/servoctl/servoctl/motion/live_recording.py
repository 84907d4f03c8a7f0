# SPDX-License-Identifier: Apache-2.0
"""A short recording of the live signals in memory, also while the axes move; recording.py writes long ones to files."""

from __future__ import annotations

import contextlib
from datetime import datetime, timezone
from types import TracebackType

import numpy as np

from ..errors import InputError, MotionError
from ..link.device import Device
from ..link.signal_stream import SETS, SignalStream
from ..show.recording import MeasuredTime, Recording

OPERATIONAL = "operational"


class LiveRecording:
    """Signals of one of SETS in every tick, from the beginning of a `with` block to its end; `recording` has them afterwards."""

    def __init__(self, device: Device, choice: str = "both") -> None:
        """Raises InputError for a choice that there is not."""
        if choice not in SETS:
            raise InputError(f"there are no signals '{choice}': expected {', '.join(SETS)}.")
        self._device = device
        self._choice = choice
        self._stack = contextlib.ExitStack()
        self._stream: SignalStream | None = None
        self._begun = datetime.now(timezone.utc)
        self._recording: Recording | None = None
        self.missing = 0
        """Samples that were lost."""

    def __enter__(self) -> LiveRecording:
        with contextlib.ExitStack() as stack:
            before = self._device.nmt_state()
            if before != OPERATIONAL:
                self._device.set_nmt(OPERATIONAL)
                stack.callback(self._device.set_nmt, before if before in ("pre-operational", "stopped") else OPERATIONAL)
            self._stream = stack.enter_context(SignalStream(self._device, self._choice))
            self._stream.start()
            self._begun = datetime.now(timezone.utc)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._stream is not None:
            self._recording = _received(self._stream, self._begun)
            self.missing = self._stream.missing
        self._stack.__exit__(kind, error, trace)

    @property
    def recording(self) -> Recording:
        """Raises MotionError when the node has sent no sample; call after the block."""
        if self._recording is None:
            raise InputError("the recording has not ended: read it after its 'with' block.")
        if not len(self._recording.time_s):
            raise MotionError(f"node {self._device.node_id} sent no sample: did the recording last for more than some ms?")
        return self._recording


def _received(stream: SignalStream, begun: datetime) -> Recording:
    samples = stream.take()
    times = MeasuredTime()
    stamps = 1e-9 * np.array([times.of(tick) for tick in samples.ticks.tolist()], dtype=np.float64)
    return Recording(stream.signals, stream.period_ms, {}, begun, stamps, samples, whole=True)
