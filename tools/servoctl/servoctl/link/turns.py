# SPDX-License-Identifier: Apache-2.0
"""Access to one node: the servoctl processes of one user and computer coordinate by file locks.

The node has one SDO server: each transfer is one turn. A long one, such as reading a capture, waits until no servoctl
moves an axis, because a motion must be monitored all the time. An axis, the fast stream and a master's id belong to one
process at a time. Other programs do not use these locks; they must
use only PDOs meanwhile.
"""

from __future__ import annotations

import contextlib
import os
import time
import zlib
from collections.abc import Iterator

from ..errors import MotionError
from .file_lock import FileLock

SETTLE_S = 0.005
"""After another process' turn: we also receive the answer to it. If both write the same object, only the time tells its answer
from ours."""


class Turns:
    """The turns at one node."""

    def __init__(self, bus: str, node_id: int) -> None:
        self._name = f"{zlib.crc32(bus.encode()):08x}-{node_id}"
        self._transfer = self.lock("transfer")
        self._motion = self.lock("motion")
        self._us = str(os.getpid())
        self._motions = 0

    def close(self) -> None:
        """Ends our part."""
        self._transfer.close()
        self._motion.close()

    def lock(self, what: str) -> FileLock:
        """A lock of this node; close it."""
        return FileLock(f"{self._name}-{what}")

    @contextlib.contextmanager
    def transfer(self) -> Iterator[None]:
        """One SDO transfer."""
        with self._transfer.held():
            if self._transfer.text != self._us:
                time.sleep(SETTLE_S)
                self._transfer.text = self._us
            yield

    @contextlib.contextmanager
    def long_transfer(self) -> Iterator[None]:
        """One SDO transfer that may take seconds."""
        with self._motion.held(), self.transfer():
            yield

    @contextlib.contextmanager
    def motion(self) -> Iterator[None]:
        """While an axis moves: transfers work as usual, without a long one of another process in between. A process may
        move both axes; the lock is free when the last motion has ended."""
        self._motions += 1
        if self._motions == 1:
            self._motion.wait(shared=True)
        try:
            yield
        finally:
            self._motions -= 1
            if self._motions == 0:
                self._motion.release()

    def anyone_moves(self) -> bool:
        """This process or another one moves an axis: a long transfer would wait."""
        with contextlib.closing(self.lock("motion")) as lock:
            return not lock.try_alone()

    @contextlib.contextmanager
    def alone(self, what: str, refusal: str) -> Iterator[None]:
        """Raises MotionError with `refusal` when another process has `what` of this node."""
        with contextlib.closing(self.lock(what)) as lock:
            if not lock.try_alone():
                raise MotionError(refusal)
            yield
