# SPDX-License-Identifier: Apache-2.0
"""Access to one node: the servoctl processes of one user and computer coordinate by file locks.

The node has one SDO server: each transfer is one turn. A long one, such as reading a capture, waits until no servoctl
moves an axis, because a motion must be monitored all the time. An axis, the fast stream and a master's id belong to one
process at a time. The kernel frees the locks of a process that ends. Other programs do not use these locks; they must
use only PDOs meanwhile.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import tempfile
import time
import zlib
from collections.abc import Iterator
from pathlib import Path

from .errors import MotionError

SETTLE_S = 0.005
"""After another process' turn: we also receive the answer to it. If both write the same object, only the time tells its answer
from ours."""


class FileLock:
    """A lock in a file of the user, in the system's folder for locks; the file stays for other processes, with its
    text."""

    def __init__(self, name: str) -> None:
        folder = Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir())
        path = folder / f"servoctl-{os.getuid()}-{name}.lock"
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)

    def wait(self, shared: bool = False) -> None:
        """Takes it, alone or shared; changes a lock that we already have."""
        fcntl.flock(self._descriptor, fcntl.LOCK_SH if shared else fcntl.LOCK_EX)

    def try_alone(self) -> bool:
        """Takes it alone if no other process has it; otherwise the lock that we had is lost."""
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True

    def release(self) -> None:
        """For the next one."""
        fcntl.flock(self._descriptor, fcntl.LOCK_UN)

    @contextlib.contextmanager
    def held(self, shared: bool = False) -> Iterator[None]:
        """Within a `with` block."""
        self.wait(shared)
        try:
            yield
        finally:
            self.release()

    @property
    def text(self) -> str:
        """Contents of the file."""
        return os.pread(self._descriptor, 100, 0).decode("ascii", errors="replace")

    @text.setter
    def text(self, text: str) -> None:
        os.ftruncate(self._descriptor, 0)
        os.pwrite(self._descriptor, text.encode("ascii"), 0)

    def close(self) -> None:
        """Releases it too."""
        os.close(self._descriptor)


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
