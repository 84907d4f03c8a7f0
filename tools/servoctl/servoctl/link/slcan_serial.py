# SPDX-License-Identifier: Apache-2.0
"""An SLCAN adapter at a serial port: python-can's bus with a reader that takes whole buffers and what adapters send between
the frames. python-can's own raises on a cut line, and hears nothing of an adapter that ends its lines with CR LF."""

from __future__ import annotations

import time
from collections import deque

import can
from can.interfaces.slcan import slcanBus

from .slcan_lines import Line, LineReader

WAIT_S = 0.01
"""Longest wait of the port for a first byte."""


class SlcanSerialBus(slcanBus):
    """Frames carry the time of the computer (s)."""

    def __init__(self, channel: str, bitrate: int, listen_only: bool = False) -> None:
        """`bitrate` in bit/s; raises can.CanError, OSError or ValueError when the port cannot be used."""
        self._reader = LineReader()
        self._messages: deque[can.Message] = deque()
        super().__init__(channel, bitrate=bitrate, listen_only=listen_only, sleep_after_open=0.1, timeout=WAIT_S)
        self.channel_info = f"SLCAN at {channel}"

    @property
    def malformed(self) -> int:
        """Lines of the adapter that were skipped."""
        return self._reader.malformed

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        end_s = None if timeout is None else time.monotonic() + timeout
        while not self._messages:
            self._messages.extend(message_of(line, time.time()) for line in self._reader.take(self._received()))
            if end_s is not None and time.monotonic() >= end_s:
                break
        return (self._messages.popleft() if self._messages else None), False

    def _received(self) -> bytes:
        """What has come; waits for a first byte as long as the port does."""
        try:
            return bytes(self.serialPortOrig.read(max(1, self.serialPortOrig.in_waiting)))
        except (OSError, TypeError) as error:  # TypeError: pyserial, when another thread has closed the port
            raise can.CanOperationError(f"{self.channel_info}: connection lost") from error

    def shutdown(self) -> None:
        """Leaves the bus, also when the adapter was unplugged."""
        try:
            super().shutdown()
        except (can.CanError, OSError):
            self.serialPortOrig.close()


def message_of(line: Line, timestamp_s: float) -> can.Message:
    """For python-can."""
    return can.Message(
        timestamp=timestamp_s, arbitration_id=line.identifier, is_extended_id=line.extended, is_remote_frame=line.remote,
        dlc=line.length, data=line.data,
    )  # fmt: skip
