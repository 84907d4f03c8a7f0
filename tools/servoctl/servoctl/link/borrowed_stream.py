# SPDX-License-Identifier: Apache-2.0
"""A stream over borrowed PDOs: they are mapped, monitored, and restored whatever happens. Subclasses define the
received frames."""

from __future__ import annotations

import abc
import contextlib
import threading
import time
from types import TracebackType
from typing import TypeVar

from ..errors import InputError, MotionError, ServoctlError
from .device import Device
from .interrupts import deaf
from .pdo_loan import PdoLoan, restore_left_over

_MIN_KBIT_S = 500
"""Three frames of 8 bytes in every tick are up to 405 kbit/s."""

SILENT_S = 2.0
"""Without a frame for this long, by the computer's clock, the node counts as silent. (A node that works but no longer
receives our frames brakes by itself, by its own clock: supervision.py.)"""
_MEASURES = "another servoctl is measuring on this node: wait until it has finished."


def _need_fast_bus(device: Device) -> None:
    """Raises InputError when the frames of every tick do not fit on the bus; other firmware does not report its bit
    rate."""
    kbit_s = int.from_bytes(device.try_upload(0x3050, 2) or b"", "little")
    if 0 < kbit_s < _MIN_KBIT_S:
        raise InputError(
            f"the bus runs at {kbit_s} kbit/s, which is too slow for a frame in every tick. At least"
            f" {_MIN_KBIT_S} kbit/s are needed, e.g. 'servoctl lss rate {_MIN_KBIT_S}000 --bitrate"
            f" {kbit_s}000'."
        )


Stream = TypeVar("Stream", bound="BorrowedStream")


class BorrowedStream(abc.ABC):
    """One axis' stream in a `with` block; frames come while the node is operational."""

    def __init__(self, device: Device, axis: int, loans: list[PdoLoan], identifiers: tuple[int, ...]) -> None:
        """`identifiers`: of the received frames."""
        self.device = device
        self.axis = axis
        self.lock = threading.Condition()
        self._loans = loans
        self._identifiers = identifiers
        self._last_frame_s = time.monotonic()
        self._emergency: int | None = None
        self._turn = contextlib.ExitStack()

    @abc.abstractmethod
    def _borrow(self) -> None:
        """Takes the loans."""

    @abc.abstractmethod
    def _take(self, which: int, data: bytes, timestamp_s: float) -> None:
        """One frame, by its place among the identifiers; called from the bus' thread, with the lock held."""

    @abc.abstractmethod
    def _forget(self) -> None:
        """Drops the received frames; called with the lock held."""

    def _check_bus(self) -> None:
        """Raises InputError when the bus is too slow for the stream."""
        _need_fast_bus(self.device)

    def __enter__(self: Stream) -> Stream:
        self._check_bus()
        network = self.device.network
        self._turn.enter_context(self.device.turns.alone("stream", _MEASURES))
        for identifier in self._identifiers:
            network.subscribe(identifier, self._frame)
        network.subscribe(0x80 + self.device.node_id, self._take_emergency)
        try:
            restore_left_over(self.device)
            self._borrow()
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        first: ServoctlError | None = None
        with deaf():
            for loan in self._loans:
                try:
                    loan.give_back()
                except ServoctlError as failed:
                    first = first or failed
        for identifier in self._identifiers:
            self.device.network.unsubscribe(identifier, self._frame)
        self.device.network.unsubscribe(0x80 + self.device.node_id, self._take_emergency)
        self._turn.close()
        if first is not None and error is None:
            raise first

    def _frame(self, identifier: int, data: bytearray, timestamp_s: float) -> None:
        with self.lock:
            self._take(self._identifiers.index(identifier), bytes(data), timestamp_s)
            self._last_frame_s = time.monotonic()
            self.lock.notify_all()

    def _take_emergency(self, _identifier: int, data: bytearray, _timestamp: float) -> None:
        self._emergency = int.from_bytes(data[:2], "little") or self._emergency

    def start(self) -> None:
        """Drops all frames received so far."""
        with self.lock:
            self._forget()
            self._last_frame_s = time.monotonic()
        self._emergency = None

    @property
    def silent_s(self) -> float:
        """Computer time since the last frame."""
        return time.monotonic() - self._last_frame_s

    def check_alive(self) -> None:
        """Raises MotionError after an emergency message, after a stop, or when the frames have stopped."""
        if self.device.stopped.is_set():
            raise MotionError("the motion was stopped.")
        if self._emergency is not None:
            raise MotionError(
                f"the node sent an emergency (code {self._emergency:04X}); 'servoctl faults' shows details."
            )
        if self.silent_s > SILENT_S:
            raise MotionError(
                f"node {self.device.node_id} sent no frame of the stream for {SILENT_S:g} s (computer time): is it"
                " switched on, operational and still on the bus?"
            )
